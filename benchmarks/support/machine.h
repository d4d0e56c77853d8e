#pragma once

#include "support/child.h"

namespace ccvt::bench {

/// Where a run was made, and with what: system, processor, memory, compiler, flags, commit,
/// versions, date.
Json machine();

/// "16 x AMD EPYC ..., GCC 12.2, -O3 -DNDEBUG, commit abc": for the head of a table.
std::string machine_line(const Json& machine);

}  // namespace ccvt::bench
