#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "io/input_file.h"
#include "io/output_file.h"

namespace ccvt {

/// What the file of a checkpoint begins with, whatever its format.
inline constexpr std::array<char, 8> kCheckpointMagic{'c', 'c', 'v', 't', 'c', 'k', 'p', 't'};

/// The file of a checkpoint: what says that it is one, with how long the two parts are; what there
/// is of the run and of all sites, which every process that continues it needs; and records of the
/// tiles, one after the other, each of a length that its capacities tell, so that processes can
/// each write and read their own. Each of these is followed by its digest().
class CheckpointWriter {
 public:
  /// `tiles`: how long the records will be, digests included. Throws IoError, as all do.
  CheckpointWriter(const std::filesystem::path& path, std::span<const std::byte> common,
                   std::uint64_t tiles);
  /// Records with their digests.
  void write(std::span<const std::byte> records) { file_.write(records.data(), records.size()); }
  /// Replaces the file of that name, at once.
  void commit() { file_.commit_now(); }

 private:
  io::OutputFile file_;
};

class CheckpointReader {
 public:
  /// Throws InvalidInput unless it is a checkpoint of this format, whole, and its first part is not
  /// damaged.
  explicit CheckpointReader(const std::filesystem::path& path);

  [[nodiscard]] std::span<const std::byte> common() const { return common_; }
  [[nodiscard]] std::uint64_t tiles() const { return tiles_; }
  /// The next so many bytes of records.
  void read(std::span<std::byte> records) { file_.read(records.data(), records.size()); }
  /// Throws InvalidInput(path: message).
  [[noreturn]] void fail(const std::string& message) const { file_.fail(message); }

 private:
  io::InputFile file_;
  std::vector<std::byte> common_;
  std::uint64_t tiles_ = 0;
};

}  // namespace ccvt
