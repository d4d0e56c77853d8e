#include <ccvt/ccvt.h>
#include <ccvt/version.h>

#include <iostream>
#include <limits>
#include <utility>

int main() {
  const Eigen::Matrix2Xd points = Eigen::Matrix2Xd::Random(2, 1000);
  const auto [sites, owners, summary] = ccvt::tessellate(points, 10, {.threads = 2, .seed = 7});
  std::cout << "ccvt " << CCVT_VERSION << ": " << summary.brief() << '\n';
  Eigen::Matrix2Xd bad = points;
  bad(1, 3) = std::numeric_limits<double>::quiet_NaN();
  int refused = 0;
  for (const auto& [given, count] : {std::pair(points, 0), std::pair(bad, 10)}) {
    try {
      ccvt::tessellate(given, count);
    } catch (const ccvt::InvalidInput& error) {  // across the border of a shared library
      std::cout << "refused: " << error.what() << '\n';
      ++refused;
    }
  }
  return refused == 2 && sites.cols() == 10 && owners.size() == 1000 ? 0 : 1;
}
