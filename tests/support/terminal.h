#pragma once

#include <string>
#include <vector>

#include "support/process.h"

namespace ccvt::test {

struct Terminal {
  /// Variables of the environment, NAME=VALUE.
  std::vector<std::string> environment = {};
  bool output = false;  ///< standard output is the terminal, too
};

#ifdef CCVT_PROGRAM
/// Runs the program with a terminal for standard error. `errors` is all that the terminal gets.
Ran run_on_terminal(const TemporaryDirectory& directory, const std::string& line,
                    const Terminal& terminal);
#endif

}  // namespace ccvt::test
