// Feeds the reader of point clouds whatever libFuzzer thinks of. Built with CCVT_FUZZ; see
// README.md.

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <vector>

#include "ccvt/point_cloud.h"
#include "support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ccvt::test::TemporaryDirectory directory;
  if (size == 0) return 0;
  const bool text = data[0] % 2 != 0;
  const auto path = directory / (text ? "p.csv" : "p.ply");
  ccvt::test::put(path, std::string_view(reinterpret_cast<const char*>(data) + 1, size - 1));
  try {
    const ccvt::PointCloud cloud = ccvt::read_point_cloud(path);
    std::vector<ccvt::Index> all(static_cast<std::size_t>(cloud.points.cols()));
    std::iota(all.begin(), all.end(), 0);
    // What is written is read as the same points.
    const auto copy = directory / (text ? "q.csv" : "q.ply");
    ccvt::write_point_cloud(copy, cloud, all, all);
    if (!text && ccvt::read_point_cloud(copy).points != cloud.points) __builtin_trap();
  } catch (const ccvt::InvalidInput&) {
    // One clear line is what a hostile file should get.
  }
  return 0;
}
