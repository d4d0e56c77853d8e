#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace ccvt::io {

/// All bytes of a file, read-only, as the system has them.
class MappedFile {
 public:
  /// Throws IoError when the system refuses, InvalidInput when the file does not have `size` bytes.
  MappedFile(const std::filesystem::path& path, std::uint64_t size);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  [[nodiscard]] const std::byte* data() const { return data_; }
  /// Throws InvalidInput if the file has been written to since.
  void check_unchanged() const;

 private:
  [[nodiscard]] struct stat status() const;

  std::string name_;
  int file_ = -1;
  std::size_t size_;
  struct timespec modified_ = {};
  const std::byte* data_ = nullptr;
};

}  // namespace ccvt::io
