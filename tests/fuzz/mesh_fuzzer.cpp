// Feeds the readers of meshes whatever libFuzzer thinks of. Built with CCVT_FUZZ; see README.md.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "ccvt/surface.h"
#include "support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ccvt::test::TemporaryDirectory directory;
  if (size == 0) return 0;
  const bool obj = data[0] % 2 == 1;
  const bool dense = data[0] / 2 % 2 == 1;
  const auto path = directory / (obj ? "m.obj" : "m.ply");
  ccvt::test::put(path, std::string_view(reinterpret_cast<const char*>(data) + 1, size - 1));
  try {
    const ccvt::TriangleMesh mesh = ccvt::read_mesh(path, dense ? (obj ? "red" : "quality") : "");
    mesh.validate();
    if (mesh.density.empty() == dense) __builtin_trap();
  } catch (const ccvt::InvalidInput&) {
    // One clear line is what a hostile file should get.
  }
  return 0;
}
