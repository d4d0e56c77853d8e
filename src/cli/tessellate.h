#pragma once

#include "ccvt/domain.h"
#include "cli/arguments.h"

/// What `tessellate` does whatever runs it.
namespace ccvt::cli {

/// Throws InvalidInput where arguments do not go together.
void check_arguments(const TessellateArguments& arguments);
/// Throws InvalidInput unless the files can be written.
void check_outputs(const TessellateArguments& arguments);

/// What the options say of the domain of points of so many dimensions.
Domain make_domain(const TessellateArguments& arguments, int dimension);

}  // namespace ccvt::cli
