#include "checkpoint/checkpoint_file.h"

#include <array>
#include <cstring>
#include <string>

#include "checkpoint/digest.h"

namespace ccvt {
namespace {

constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::uint32_t kFormat = 7;

struct Header {
  std::array<char, 8> magic = kCheckpointMagic;
  std::uint32_t byte_order = kByteOrder;
  std::uint32_t format = kFormat;
  std::uint64_t common = 0;  ///< bytes, without their digest
  std::uint64_t tiles = 0;   ///< bytes, digests included
  std::uint64_t own_digest = 0;

  [[nodiscard]] std::uint64_t digest_now() const {
    return digest(std::as_bytes(std::span(this, 1)).first(offsetof(Header, own_digest)));
  }
};
static_assert(std::has_unique_object_representations_v<Header>);

}  // namespace

CheckpointWriter::CheckpointWriter(const std::filesystem::path& path,
                                   std::span<const std::byte> common, std::uint64_t tiles)
    : file_(path) {
  Header header;
  header.common = common.size();
  header.tiles = tiles;
  header.own_digest = header.digest_now();
  file_.write(&header, sizeof header);
  file_.write(common.data(), common.size());
  const std::uint64_t end = digest(common);
  file_.write(&end, sizeof end);
}

CheckpointReader::CheckpointReader(const std::filesystem::path& path) : file_(path) {
  Header header;
  if (file_.read_some(&header, sizeof header) < sizeof header || header.magic != kCheckpointMagic) {
    fail("is not a checkpoint of ccvt, or not all of one");
  }
  if (header.byte_order != kByteOrder) fail("was written by a machine of another byte order");
  if (header.format != kFormat) {
    fail("has the format " + std::to_string(header.format) + " of checkpoints, and only " +
         std::to_string(kFormat) + " can be continued");
  }
  if (header.own_digest != header.digest_now()) fail("is damaged: its header is not as written");
  const std::uint64_t around = sizeof header + sizeof(std::uint64_t);
  const bool possible = header.common <= file_.size() && header.tiles <= file_.size();
  if (!possible || header.common + header.tiles + around != file_.size()) {
    fail("has " + std::to_string(file_.size()) + " bytes, but was written with " +
         std::to_string(header.common + header.tiles + around));
  }
  common_.resize(static_cast<std::size_t>(header.common));
  file_.read(common_.data(), common_.size());
  std::uint64_t end = 0;
  file_.read(&end, sizeof end);
  if (end != digest(common_)) fail("is damaged: what it has of the sites is not as written");
  tiles_ = header.tiles;
}

}  // namespace ccvt
