#pragma once

#include <string>

namespace ccvt::cli {

/// What `ccvt --version` prints: the first line is "ccvt" and the version, and nothing else.
std::string version_text();

}  // namespace ccvt::cli
