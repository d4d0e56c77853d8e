#include "ccvt/volume.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/streams.h"

namespace ccvt::cli {

namespace {

/// Throws unless the mask has the cells of the volume, at the same places.
void check_mask(const VolumeArguments& arguments, const VolumeHeader& volume,
                const VolumeHeader& mask) {
  const auto shape = [](const VolumeHeader& header) {
    std::string result;
    for (const auto n : header.grid.shape) {
      result += (result.empty() ? "" : " x ") + std::to_string(n);
    }
    return result;
  };
  if (volume.grid.shape != mask.grid.shape) {
    throw InvalidInput(arguments.mask.string() + ": has " + shape(mask) + " cells, but " +
                       arguments.volume.string() + " has " + shape(volume));
  }
  const double cell = volume.grid.spacing().minCoeff();
  const Eigen::Vector3d last(static_cast<double>(mask.grid.shape[0]),
                             static_cast<double>(mask.grid.shape[1]),
                             static_cast<double>(mask.grid.shape[2]));
  const Eigen::Vector3d near = volume.grid.origin.eigen() - mask.grid.origin.eigen();
  const Eigen::Vector3d far = near + (volume.grid.axes.eigen() - mask.grid.axes.eigen()) * last;
  if (near.norm() > 0.1 * cell || far.norm() > 0.1 * cell) {
    throw InvalidInput(arguments.mask.string() + ": its cells are not where those of " +
                       arguments.volume.string() + " are; resample it first");
  }
}

std::vector<std::uint8_t> read_mask(const VolumeArguments& arguments) {
  if (arguments.mask.empty()) return {};
  const Volume file = read_volume(arguments.mask, arguments.layout);
  std::vector<std::uint8_t> mask(file.cells());
  std::visit(
      [&](const auto& values) {
        std::transform(values.begin(), values.end(), mask.begin(), [](auto value) {
          return value != decltype(value){0} ? std::uint8_t{1} : std::uint8_t{0};
        });
      },
      file.stored());
  return mask;
}

template <class Scalar>
int sample(const VolumeArguments& arguments, const VolumeHeader& header,
           const std::optional<VolumeHeader>& mask_header) {
  const std::uint64_t count = static_cast<std::uint64_t>(arguments.sites) *
                              static_cast<std::uint64_t>(arguments.points_per_site);
  const std::uint64_t mask_bytes = mask_header ? header.cells() + mask_header->bytes() : 0;
  const std::string needed = check_memory("--sites " + std::to_string(arguments.sites), count, 3,
                                          sizeof(Scalar), header.bytes() + mask_bytes);
  if (!arguments.quiet) print("needs about " + needed + " of memory\n");

  const Volume volume = read_volume(arguments.volume, arguments.layout);
  const std::vector<std::uint8_t> mask = read_mask(arguments);
  const DensityGrid density =
      blame(arguments.volume, [&] { return volume.density(arguments.map, mask); });

  VolumeOptions options;
  options.points_per_site = arguments.points_per_site;
  const VolumeSamples<Scalar> samples = blame(arguments.volume, [&] {
    Progress progress(arguments.quiet);
    options.tessellation = make_options(arguments, arguments.sites, progress);
    return sample_volume<Scalar>(density, arguments.sites, options);
  });
  Publication outputs;
  if (!arguments.preview.empty()) write_png(arguments.preview, preview(density, samples.sites));
  write_summary(arguments, samples.summary);
  write_samples(arguments.output, samples);
  return finish(arguments, outputs, samples.summary);
}

}  // namespace

int run_volume(const VolumeArguments& arguments) {
  const VolumeHeader header = inspect_volume(arguments.volume, arguments.layout);
  std::optional<VolumeHeader> mask;
  if (!arguments.mask.empty()) {
    mask = inspect_volume(arguments.mask, arguments.layout);
    check_mask(arguments, header, *mask);
  }
  Outputs()
      .add("--output", arguments.output, io::kSampleFiles)
      .add("--preview", arguments.preview, io::kPictureFiles)
      .add("--summary", arguments.summary)
      .add_input("FILE", arguments.volume)
      .add_input("the data file of FILE", header.data_file)
      .add_input("--mask", arguments.mask)
      .add_input("the data file of --mask", mask ? mask->data_file : "")
      .check();
  return arguments.scalar == ScalarType::float64 ? sample<double>(arguments, header, mask)
                                                 : sample<float>(arguments, header, mask);
}

}  // namespace ccvt::cli
