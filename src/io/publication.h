#pragma once

#include "ccvt/export.h"
#include "io/unfinished_file.h"

namespace ccvt::io {

/// Hands a complete file to the innermost Publication of this thread, or publishes it when there is
/// none. Throws IoError.
CCVT_EXPORT void publish(UnfinishedFile file);

}  // namespace ccvt::io
