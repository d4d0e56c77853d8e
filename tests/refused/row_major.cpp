// Must not compile: see tests/CMakeLists.txt.
#include <ccvt/ccvt.h>
