#pragma once

#include <cstdint>
#include <string>

#include "ccvt/codebook.h"
#include "cli/arguments.h"

namespace ccvt::cli {

/// Throws InvalidInput unless all outputs can be written.
void check_outputs(const EncodeArguments& arguments);

/// The closing line.
std::string describe_codes(std::int64_t vectors, Index codewords, double distortion,
                           const CodeUsage& usage, double seconds);

}  // namespace ccvt::cli
