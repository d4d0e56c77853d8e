#pragma once

#include <string>

namespace ccvt::cli {

/// Where a standard stream is closed, puts in its place one that can be neither read nor written:
/// else the first file that is opened would be taken for it.
void fill_closed_streams();

/// Prints at once: on standard output, or, where a file goes there, on standard error. Throws
/// IoError.
void print(const std::string& text);

/// Throws IoError, for the reason that errno gives.
[[noreturn]] void fail_to_print();

}  // namespace ccvt::cli
