// Must not compile: see tests/CMakeLists.txt.
#include <ccvt/ccvt.h>

void take_integers(const Eigen::MatrixXi& points) { CCVT_CALL; }
