#include "ccvt/volume.h"

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <variant>
#include <vector>

#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"

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

std::vector<std::uint8_t> read_mask(const VolumeArguments& arguments, const VolumeHeader& volume) {
  if (arguments.mask.empty()) return {};
  check_mask(arguments, volume, inspect_volume(arguments.mask, arguments.layout));
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
int sample(const VolumeArguments& arguments) {
  const std::uint64_t count = static_cast<std::uint64_t>(arguments.sites) *
                              static_cast<std::uint64_t>(arguments.points_per_site);
  const VolumeHeader header = inspect_volume(arguments.volume, arguments.layout);
  const std::uint64_t mask_bytes =
      arguments.mask.empty()
          ? 0
          : header.cells() + inspect_volume(arguments.mask, arguments.layout).bytes();
  const std::string needed = check_memory("--sites " + std::to_string(arguments.sites), count, 3,
                                          sizeof(Scalar), header.bytes() + mask_bytes);
  if (!arguments.quiet) std::cout << "needs about " << needed << " of memory" << std::endl;

  const Volume volume = read_volume(arguments.volume, arguments.layout);
  stop_if_interrupted();
  const std::vector<std::uint8_t> mask = read_mask(arguments, volume);
  const DensityGrid density =
      blame(arguments.volume, [&] { return volume.density(arguments.map, mask); });
  stop_if_interrupted();

  VolumeOptions options;
  options.points_per_site = arguments.points_per_site;
  const VolumeSamples<Scalar> samples = blame(arguments.volume, [&] {
    Progress progress(arguments.quiet);
    options.tessellation = make_options(arguments, arguments.sites, progress);
    return sample_volume<Scalar>(density, arguments.sites, options);
  });
  write_samples(arguments.output, samples);
  if (!arguments.preview.empty()) write_png(arguments.preview, preview(density, samples.sites));
  return finish(arguments, samples.summary);
}

}  // namespace

int run_volume(const VolumeArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kSampleFiles)
      .add("--preview", arguments.preview, io::kPictureFiles)
      .add("--summary", arguments.summary)
      .add_input("FILE", arguments.volume)
      .add_input("--mask", arguments.mask)
      .check();
  return arguments.scalar == ScalarType::float64 ? sample<double>(arguments)
                                                 : sample<float>(arguments);
}

}  // namespace ccvt::cli
