#include "ccvt/volume.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/volume_input.h"
#include "cli/volume_mask.h"
#include "commands.h"
#include "parallel/together.h"
#include "results.h"

namespace ccvt::mpi {
namespace {

using cli::VolumeArguments;

/// What the headers of FILE and --mask say.
struct Headers {
  VolumeHeader volume;
  std::optional<VolumeHeader> mask;

  /// How many cells so many layers have.
  [[nodiscard]] std::uint64_t cells_of(std::int64_t layers) const {
    const std::int64_t all = layers_of_rank(volume.grid.shape, 0, 1).end;
    return volume.cells() / static_cast<std::uint64_t>(all) * static_cast<std::uint64_t>(layers);
  }
};

/// What a rank has of them.
struct Part {
  LayerRange layers;
  Volume volume;
  std::vector<std::uint8_t> mask;
};

Headers check(const Session& session, const VolumeArguments& arguments) {
  Headers headers;
  session.together([&] {
    cli::check_mask_options(arguments);
    cli::Outputs outputs;
    outputs.add("--output", arguments.output, io::kSampleFiles)
        .add("--summary", arguments.summary)
        .add_input("FILE", arguments.volume)
        .add_input("--mask", arguments.mask);
    if (session.is_first()) outputs.check();
    headers.volume = cli::inspect_input(arguments.volume, cli::layout_of_volume(arguments));
    if (!arguments.mask.empty()) {
      headers.mask = cli::inspect_mask(arguments, headers.volume);
      cli::check_mask_of_parts(arguments, headers.volume, *headers.mask);
    }
    outputs.add_input("the data file of FILE", headers.volume.data_file)
        .add_input("the data file of --mask", headers.mask ? headers.mask->data_file : "");
    if (session.is_first()) outputs.check();
  });
  return headers;
}

/// Throws unless there is memory for a rank's layers and points.
void check_memory(const Session& session, const VolumeArguments& arguments, const Headers& headers,
                  const LayerRange& layers, std::size_t scalar_bytes) {
  const std::int64_t all = std::int64_t{arguments.sites} * arguments.points_per_site;
  Session::check_count(arguments.sites, arguments.points_per_site);
  const std::uint64_t cells = headers.cells_of(layers.end - layers.begin);
  const std::uint64_t of_mask = headers.mask ? 1 + bytes_of(headers.mask->type) : 0;
  session.check_memory(
      "--sites " + std::to_string(arguments.sites), session.share(all).size(), 3, scalar_bytes,
      arguments.points_per_site,
      static_cast<std::int64_t>(cells * (bytes_of(headers.volume.type) + of_mask)));
}

Part read(const Session& session, const VolumeArguments& arguments, const Headers& headers,
          std::size_t scalar_bytes) {
  const MpiRanks& ranks = session.ranks();
  Part part{layers_of_rank(headers.volume.grid.shape, ranks.rank(), ranks.count()), {}, {}};
  cli::ValueRange values;
  session.together([&] {
    check_memory(session, arguments, headers, part.layers, scalar_bytes);
    part.volume = read_volume(arguments.volume, cli::layout_of_volume(arguments), part.layers);
    if (!headers.mask) return;
    part.mask = cli::mask_of(
        arguments, read_volume(arguments.mask, cli::layout_of_mask(arguments), part.layers));
  });
  const bool counts = any(&session.ranks(), cli::counts(part.mask));
  session.together([&] {
    if (headers.mask && !counts) cli::refuse_mask(arguments);
    values = cli::check_each_value(arguments, part.volume, part.mask,
                                   headers.cells_of(part.layers.begin));
  });
  const std::vector<double> least = of_all(&session.ranks(), values.least);
  const std::vector<double> most = of_all(&session.ranks(), values.most);
  values = {*std::min_element(least.begin(), least.end()),
            *std::max_element(most.begin(), most.end())};
  cli::check_range(arguments, values);
  return part;
}

template <class Scalar>
int sample(const Session& session, const VolumeArguments& arguments, const Headers& headers) {
  const Kept kept(session, arguments);
  const Part part = read(session, arguments, headers, sizeof(Scalar));
  const VolumeSamples samples = cli::blame(arguments.volume, [&] {
    DensityLayers density =
        density_layers(session.ranks(), headers.volume, part.volume, arguments.map, part.mask);
    density.grid.interpolation = arguments.interpolation;
    VolumeOptions options;
    options.points_per_site = arguments.points_per_site;
    return kept.solve(options.tessellation, arguments.sites, [&](const Options& tessellation) {
      options.tessellation = tessellation;
      return sample_volume<Scalar>(session.ranks(), density, arguments.sites, options);
    });
  });
  return finish(
      session, arguments, kept, samples.summary, [&] { write_samples(arguments.output, samples); },
      PutBack{samples.put_back, samples.farthest_put_back});
}

}  // namespace

int run_volume(const Session& session, const VolumeArguments& given) {
  const VolumeArguments arguments = session.own(given);
  const Headers headers = check(session, arguments);
  require_one_file(session, arguments.volume, headers.volume);
  if (headers.mask) require_one_file(session, arguments.mask, *headers.mask);
  return arguments.scalar == ScalarType::float64 ? sample<double>(session, arguments, headers)
                                                 : sample<float>(session, arguments, headers);
}

}  // namespace ccvt::mpi
