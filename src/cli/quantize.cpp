#include "cli/quantize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "ccvt/mapped_points.h"
#include "ccvt/problem.h"
#include "ccvt/version.h"
#include "cli/blocks.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/rank_json.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/standard_streams.h"
#include "cli/streams.h"
#include "io/formats.h"

namespace ccvt::cli {

namespace {

/// What training takes is told beforehand from here on: 1 GiB.
constexpr double kWorthTelling = 1024.0 * 1024 * 1024;

bool seeds_from_file(const QuantizeArguments& arguments) {
  return arguments.seeding != "kmeans++" && arguments.seeding != "random";
}

}  // namespace

CodebookOptions make_codebook_options(const QuantizeArguments& arguments, Progress& progress) {
  CodebookOptions options;
  options.method = arguments.method;
  if (arguments.seeding == "random") options.seeding = Seeding::random;
  options.restarts = arguments.restarts;
  options.effort = arguments.effort;
  options.seed = arguments.seed;
  options.threads = arguments.threads;
  if (arguments.max_iterations) options.max_iterations = *arguments.max_iterations;
  options.tolerance = arguments.energy_tolerance;
  options.time_limit = arguments.time_limit;
  options.gap = arguments.gap;
  options.train_sample = arguments.train_sample;
  options.on_iteration = [&progress, sites = arguments.codewords](const IterationRecord& record) {
    progress.show(record, sites);
    return true;
  };
  options.cancelled = watch_interrupts();
  return options;
}

void write_summary(const QuantizeArguments& arguments, const CodebookSummary& summary,
                   std::optional<double> psnr, const std::optional<RankFigures>& ranks) {
  if (arguments.summary.empty()) return;
  nlohmann::ordered_json json;
  json["version"] = CCVT_VERSION;
  json["command"] = arguments.command;
  json["method"] = to_string(summary.method);
  json["termination"] = to_string(summary.termination);
  json["dimension"] = summary.dimension;
  json["vectors"] = summary.vectors;
  json["codewords"] = summary.codewords;
  json["seed"] = summary.seed;
  json["threads"] = summary.threads_used;
  json["iterations"] = summary.iterations;
  json["energy"] = summary.energy;
  json["distortion"] = summary.distortion;
  json["gap"] = summary.gap;
  json["imbalance"] = summary.usage.imbalance;
  json["smallest_cell"] = summary.usage.smallest;
  json["largest_cell"] = summary.usage.largest;
  json["entropy_bits"] = summary.usage.entropy;
  if (psnr) json["psnr_db"] = *psnr;
  json["seconds"] = {{"total", summary.seconds_total}, {"seeding", summary.seconds_seeding}};
  json["peak_memory_bytes"] = peak_memory_bytes();
  if (ranks) json["ranks"] = json_of(*ranks);
  json["warnings"] = summary.warnings;
  write_text(arguments.summary, json.dump(2) + "\n");
}

std::optional<Points<double>> read_codewords(const QuantizeArguments& arguments) {
  if (!seeds_from_file(arguments)) return {};
  if (io::extension_of(arguments.seeding).empty()) {
    throw InvalidInput("--seeding: '" + arguments.seeding +
                       "' is neither kmeans++ nor random nor a file of codewords, " +
                       io::list_of(io::kPointFiles, " or "));
  }
  Points<double> codewords = read_points<double>(arguments.seeding);
  if (codewords.cols() != arguments.codewords) {
    throw InvalidInput(arguments.seeding + ": has " + std::to_string(codewords.cols()) +
                       " codewords, but --codewords is " + std::to_string(arguments.codewords));
  }
  return codewords;
}

void check_codewords(const QuantizeArguments& arguments, const PointsHeader& header) {
  if (std::cmp_less_equal(arguments.codewords, header.count)) return;
  throw InvalidInput(arguments.vectors.string() + ": has " + std::to_string(header.count) +
                     " vectors, but --codewords is " + std::to_string(arguments.codewords) +
                     ": each needs one at least");
}

void check_memory(const QuantizeArguments& arguments, const PointsHeader& header,
                  std::uint64_t vectors, double beside, std::uint64_t processes) {
  const std::string name = arguments.vectors.string();
  const bool single = header.scalar == ScalarType::float32;
  const bool mapped = single ? MappedPoints<float>::can_map(arguments.vectors, arguments.reading)
                             : MappedPoints<double>::can_map(arguments.vectors, arguments.reading);
  const double each =
      beside +
      training_bytes({vectors, header.dimension, single ? sizeof(float) : sizeof(double), mapped},
                     arguments.codewords, arguments.method != CodebookMethod::lloyd);
  const double bytes = static_cast<double>(processes) * each;
  const std::string needed =
      check_bytes(name, std::min<std::uint64_t>(processes * vectors, header.count),
                  header.dimension, bytes, processes);
  if (!arguments.quiet && bytes >= kWorthTelling) {
    tell(name + ": training takes up to about " + needed + " of memory");
  }
}

void check_arguments(const QuantizeArguments& arguments) {
  if (!arguments.image_out.empty() && arguments.image_blocks == 0) {
    throw InvalidInput("--image-out: needs --image-blocks; see " + program_name() +
                       " quantize --help");
  }
  if (!arguments.weights_out.empty() && arguments.method != CodebookMethod::exact) {
    throw InvalidInput("--weights-out: only --method exact finds weights");
  }
  if (arguments.gap > 0 && arguments.method != CodebookMethod::exact) {
    throw InvalidInput("--gap: only --method exact proves one");
  }
  if (arguments.train_sample > 0 && arguments.method != CodebookMethod::exact) {
    throw InvalidInput("--train-sample: only --method exact assigns all vectors in the end");
  }
  if (arguments.train_sample > 0 && arguments.train_sample < arguments.codewords) {
    throw InvalidInput("--train-sample: " + std::to_string(arguments.train_sample) +
                       " vectors are fewer than the " + std::to_string(arguments.codewords) +
                       " codewords that they train");
  }
  if (arguments.effort.value_or(0) > 0 && arguments.method == CodebookMethod::lloyd) {
    throw InvalidInput("--effort: --method lloyd keeps no capacities to search with");
  }
  if (arguments.effort.value_or(0) > 0 && seeds_from_file(arguments)) {
    throw InvalidInput("--effort: codewords from a file, --seeding, take the place of bred ones");
  }
  if (arguments.restarts > 0 && seeds_from_file(arguments)) {
    throw InvalidInput("--restarts: codewords from a file, --seeding, are not drawn anew");
  }
  if (!arguments.capacities.empty() && arguments.method == CodebookMethod::lloyd) {
    throw InvalidInput("--capacities: --method lloyd does not keep any");
  }
  if (arguments.image_blocks > 0 && !arguments.reading.columns.empty()) {
    throw InvalidInput("--columns: a picture, which --image-blocks reads, has none");
  }
}

void check_outputs(const QuantizeArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kTableFiles)
      .add("--codes-out", arguments.codes_out, io::kTableFiles)
      .add("--weights-out", arguments.weights_out, io::kTableFiles)
      .add("--image-out", arguments.image_out, io::kPictureFiles)
      .add("--summary", arguments.summary)
      .add_input("VECTORS", arguments.vectors)
      .add_input("--capacities", arguments.capacities)
      .add_input("--seeding", seeds_from_file(arguments) ? arguments.seeding : "")
      .check();
}

namespace {

template <class Scalar>
Training train(const QuantizeArguments& arguments, const std::string& source,
               PointsView<Scalar> vectors) {
  std::vector<Index> capacities;
  if (!arguments.capacities.empty()) {
    capacities = read_indices(arguments.capacities);
    auto problem = blame(
        source, [&] { return Problem<Scalar>(vectors, arguments.codewords, arguments.threads); });
    blame(arguments.capacities, [&] { problem.set_capacities(capacities); });
  }
  const std::optional<Points<double>> codewords = read_codewords(arguments);
  Progress progress(arguments.quiet, arguments.time_limit);
  CodebookOptions options = make_codebook_options(arguments, progress);
  options.capacities = std::move(capacities);
  if (codewords) {
    return blame(arguments.seeding,
                 [&] { return train_codebook_from(vectors, *codewords, options); });
  }
  return blame(source, [&] { return train_codebook(vectors, arguments.codewords, options); });
}

/// Writes all but the decoded picture, publishes, and prints the closing line.
int finish_training(const QuantizeArguments& arguments, Publication& outputs,
                    const Training& training, std::optional<double> psnr) {
  if (!arguments.codes_out.empty()) write_owners(arguments.codes_out, training.codes);
  write_summary(arguments, training.summary, psnr);
  training.codebook.save(arguments.output, arguments.weights_out);
  const int status = publish(outputs);
  warn(arguments.quiet, training.summary.warnings);
  std::string quality;
  if (psnr && std::isfinite(*psnr)) {
    std::array<char, 40> number{};
    std::snprintf(number.data(), number.size(), ", PSNR %.2f dB", *psnr);
    quality = number.data();
  } else if (psnr) {
    quality = ", PSNR n/a (no pixel differs)";
  }
  if (!arguments.quiet) print(training.summary.brief() + quality + "\n");
  return status;
}

template <class Scalar>
int quantize_vectors(const QuantizeArguments& arguments, const PointsHeader& header) {
  check_codewords(arguments, header);
  check_memory(arguments, header, header.count);
  tell_if_cut_short(arguments.vectors);
  const MappedPoints<Scalar> vectors(arguments.vectors, arguments.reading);
  const Training training = train(arguments, arguments.vectors.string(), vectors.view());
  vectors.check_unchanged();
  Publication outputs;
  return finish_training(arguments, outputs, training, {});
}

int quantize_picture(const QuantizeArguments& arguments) {
  const ColourImage image = read_colour_image(arguments.vectors);
  const Points<float> blocks =
      blame(arguments.vectors, [&] { return blocks_of(image, arguments.image_blocks); });
  const Training training = train(arguments, arguments.vectors.string(), view_points(blocks));
  const ColourImage decoded = picture_of(training.codebook.decode(training.codes), image.width,
                                         image.height, arguments.image_blocks);
  Publication outputs;
  if (!arguments.image_out.empty()) write_png(arguments.image_out, decoded);
  return finish_training(arguments, outputs, training, peak_signal_to_noise(image, decoded));
}

}  // namespace

int run_quantize(const QuantizeArguments& arguments) {
  check_arguments(arguments);
  check_outputs(arguments);
  if (arguments.image_blocks > 0) return quantize_picture(arguments);
  const PointsHeader header =
      inspect_and_tell(arguments.vectors, arguments.reading, arguments.quiet);
  return header.scalar == ScalarType::float32 ? quantize_vectors<float>(arguments, header)
                                              : quantize_vectors<double>(arguments, header);
}

}  // namespace ccvt::cli
