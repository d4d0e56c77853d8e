#include <ccvt/ccvt.h>
#include <ccvt/version.h>

#include <iostream>

int main() {
  const Eigen::Matrix2Xd points = Eigen::Matrix2Xd::Random(2, 1000);
  const auto [sites, owners, summary] = ccvt::tessellate(points, 10, {.threads = 2, .seed = 7});
  std::cout << "ccvt " << CCVT_VERSION << ": " << summary.brief() << '\n';
  try {
    ccvt::tessellate(points, 0);
  } catch (const ccvt::InvalidInput& error) {  // across the border of a shared library
    std::cout << "refused: " << error.what() << '\n';
    return sites.cols() == 10 && owners.size() == 1000 ? 0 : 1;
  }
  return 1;
}
