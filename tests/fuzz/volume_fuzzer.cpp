// Feeds the readers of volumes whatever libFuzzer thinks of. Built with CCVT_FUZZ; see README.md.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "ccvt/volume.h"
#include "support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ccvt::test::TemporaryDirectory directory;
  constexpr const char* names[] = {"v.nii", "v.nii.gz", "v.nrrd", "v.npy", "v.raw"};
  if (size == 0) return 0;
  const auto path = directory / names[data[0] % 5];
  ccvt::VolumeLayout layout;
  if (data[0] % 5 == 4) {
    layout.shape = {size > 1 ? data[1] : 1, 3, 2};
    layout.type = static_cast<ccvt::VoxelType>(data[0] / 5 % 10);
  }
  ccvt::test::put(path, std::string_view(reinterpret_cast<const char*>(data) + 1, size - 1));
  try {
    const ccvt::Volume volume = ccvt::read_volume(path, layout);
    if (volume.data.size() != volume.bytes()) __builtin_trap();
  } catch (const ccvt::InvalidInput&) {
    // One clear line is what a hostile file should get.
  }
  return 0;
}
