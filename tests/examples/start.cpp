// Ten lines to start with: 256,000 random points in space become 1000 cells of 256 points each.
//   g++ -std=c++20 -O2 start.cpp $(pkg-config --cflags --libs ccvt) -o start && ./start
#include <ccvt/ccvt.h>

#include <iostream>

int main() {
  const auto points = ccvt::sample_uniform<double, 3>(ccvt::Box::unit(3), 256'000, /*seed=*/1);
  const auto [sites, owners, summary] = ccvt::tessellate(points, 1000, {.threads = 8, .seed = 7});
  std::cout << summary.brief() << "\nfirst site: " << sites.col(0).transpose() << "\n";
}
