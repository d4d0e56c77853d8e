#include "ccvt/volume.h"

#include <cstdint>
#include <optional>
#include <vector>

#include "cli/kept_run.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/streams.h"
#include "cli/volume_input.h"
#include "cli/volume_mask.h"

namespace ccvt::cli {

namespace {

template <class Scalar>
int sample(const VolumeArguments& arguments, const VolumeHeader& header,
           const std::optional<VolumeHeader>& mask_header) {
  const KeptRun kept(arguments);
  const std::uint64_t mask_bytes = mask_header ? header.cells() + mask_header->bytes() : 0;
  check_cells(arguments.volume, header.cells(), header.bytes() + mask_bytes);
  const std::string needed = check_memory(arguments.sites, arguments.points_per_site, 3,
                                          sizeof(Scalar), header.bytes() + mask_bytes);
  if (!arguments.quiet) print("needs about " + needed + " of memory\n");

  const Volume volume = read_volume(arguments.volume, layout_of_volume(arguments));
  std::vector<std::uint8_t> mask;
  if (mask_header) mask = read_mask(arguments, volume, *mask_header);
  check_values(arguments, volume, mask);
  DensityGrid density =
      blame(arguments.volume, [&] { return volume.density(arguments.map, mask); });
  density.interpolation = arguments.interpolation;

  VolumeOptions options;
  options.points_per_site = arguments.points_per_site;
  const VolumeSamples samples = kept.blame(arguments.volume, [&] {
    Progress progress(arguments.quiet, arguments.time_limit);
    options.tessellation = kept.options(
        make_options(arguments, options.tessellation, arguments.sites, progress), progress);
    return sample_volume<Scalar>(density, arguments.sites, options);
  });
  Publication outputs;
  if (!arguments.preview.empty()) write_png(arguments.preview, preview(density, samples.sites));
  const PutBack put_back{samples.put_back, samples.farthest_put_back};
  write_summary(arguments, samples.summary, put_back);
  write_samples(arguments.output, samples);
  const int status = finish(arguments, outputs, samples.summary, put_back);
  kept.end(samples.summary);
  return status;
}

}  // namespace

int run_volume(const VolumeArguments& arguments) {
  check_mask_options(arguments);
  Outputs outputs;
  outputs.add("--output", arguments.output, io::kSampleFiles)
      .add("--preview", arguments.preview, io::kPictureFiles)
      .add("--summary", arguments.summary)
      .add_input("FILE", arguments.volume)
      .add_input("--checkpoint", checkpoint_file(arguments))
      .add_input("--mask", arguments.mask)
      .check();
  const VolumeHeader header = inspect_input(arguments.volume, layout_of_volume(arguments));
  std::optional<VolumeHeader> mask;
  if (!arguments.mask.empty()) mask = inspect_mask(arguments, header);
  // Headers tell which files hold the data.
  outputs.add_input("the data file of FILE", header.data_file)
      .add_input("the data file of --mask", mask ? mask->data_file : "")
      .check();
  return arguments.scalar == ScalarType::float64 ? sample<double>(arguments, header, mask)
                                                 : sample<float>(arguments, header, mask);
}

}  // namespace ccvt::cli
