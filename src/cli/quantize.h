#pragma once

#include <cstdint>
#include <optional>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "cli/arguments.h"
#include "cli/progress.h"
#include "cli/run.h"

namespace ccvt::cli {

/// Throws InvalidInput for options that do not go together.
void check_arguments(const QuantizeArguments& arguments);
/// Throws InvalidInput unless all outputs can be written.
void check_outputs(const QuantizeArguments& arguments);
/// Throws InvalidInput unless there is a vector for each codeword.
void check_codewords(const QuantizeArguments& arguments, const PointsHeader& header);
/// Throws InvalidInput unless there is memory to train on so many of the vectors; says how much it
/// takes, if that is worth telling. `processes` on this machine each do so, and hold `beside` bytes
/// more.
void check_memory(const QuantizeArguments& arguments, const PointsHeader& header,
                  std::uint64_t vectors, double beside = 0, std::uint64_t processes = 1);

/// Options that draw on `progress`, which must outlive them, and end training when the user
/// interrupts it. Without capacities.
CodebookOptions make_codebook_options(const QuantizeArguments& arguments, Progress& progress);
/// The codewords to start from, where they come from a file.
std::optional<Points<double>> read_codewords(const QuantizeArguments& arguments);

/// Writes the summary file, if there is to be one.
void write_summary(const QuantizeArguments& arguments, const CodebookSummary& summary,
                   std::optional<double> psnr, const std::optional<RankFigures>& ranks = {});

}  // namespace ccvt::cli
