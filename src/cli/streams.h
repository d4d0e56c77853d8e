#pragma once

#include <string>

namespace ccvt::cli {

/// Where a standard stream is closed, puts in its place one that can be neither read nor written:
/// else the first file that is opened would be taken for it.
void fill_closed_streams();

/// Prints on standard output, at once. Throws IoError.
void print(const std::string& text);

}  // namespace ccvt::cli
