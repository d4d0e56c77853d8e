#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "io/input_file.h"

namespace ccvt::io {

/// The bytes of a file from where it stands to its end, unpacked if they are packed by gzip.
class ByteStream {
 public:
  /// `left`: how many bytes of `file` there are. Neither must end before the stream does.
  ByteStream(InputFile& file, std::uint64_t left, bool gzip);
  ~ByteStream();
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  /// Throws InvalidInput when there are fewer, or what is packed is damaged.
  void read(void* data, std::size_t count);
  void skip(std::uint64_t count);
  /// No more bytes than these can follow: of what is packed, 1032 for each byte, which is the most
  /// that deflate can do.
  [[nodiscard]] std::uint64_t most_left() const;
  /// Throws InvalidInput when there are more bytes, or the checksum of what is packed is wrong.
  void expect_end();

  [[nodiscard]] const InputFile& file() const { return file_; }

 private:
  struct Inflater;
  std::size_t read_some(void* data, std::size_t count);

  InputFile& file_;
  std::uint64_t left_;
  std::unique_ptr<Inflater> inflater_;
};

}  // namespace ccvt::io
