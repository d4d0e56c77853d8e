#include "io/byte_stream.h"

#include <zlib.h>

#include <algorithm>
#include <new>
#include <string>
#include <vector>

namespace ccvt::io {

namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr std::uint64_t kMostRatio = 1032;

}  // namespace

struct ByteStream::Inflater {
  Inflater() {
    // 16: the gzip format, header and checksum included.
    if (inflateInit2(&state, 15 + 16) != Z_OK) throw std::bad_alloc();
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&state); }

  z_stream state = {};
  std::vector<unsigned char> packed = std::vector<unsigned char>(kBlock);
  bool ended = false;  // at the end of a member
};

ByteStream::ByteStream(InputFile& file, std::uint64_t left, bool gzip) : file_(file), left_(left) {
  if (gzip) inflater_ = std::make_unique<Inflater>();
}

ByteStream::~ByteStream() = default;

std::uint64_t ByteStream::most_left() const {
  if (!inflater_) return left_;
  const std::uint64_t packed = left_ + inflater_->state.avail_in;
  return packed > UINT64_MAX / kMostRatio - kBlock ? UINT64_MAX : packed * kMostRatio + kBlock;
}

std::size_t ByteStream::read_some(void* data, std::size_t count) {
  if (!inflater_) {
    const std::size_t got = file_.read_some(data, std::min<std::uint64_t>(count, left_));
    left_ -= got;
    return got;
  }
  z_stream& state = inflater_->state;
  auto* target = static_cast<unsigned char*>(data);
  std::size_t done = 0;
  while (done < count) {
    if (state.avail_in == 0 && left_ > 0) {
      const auto wanted = std::min<std::uint64_t>(kBlock, left_);
      file_.read(inflater_->packed.data(), wanted);
      left_ -= wanted;
      state.next_in = inflater_->packed.data();
      state.avail_in = static_cast<uInt>(wanted);
    }
    if (inflater_->ended) {
      while (state.avail_in > 0 && *state.next_in == 0) {  // padding
        ++state.next_in;
        --state.avail_in;
      }
      if (state.avail_in == 0 && left_ > 0) continue;
      if (state.avail_in == 0) break;
      if (inflateReset(&state) != Z_OK) throw std::bad_alloc();
      inflater_->ended = false;  // a further member follows
    }
    const auto room = static_cast<uInt>(std::min<std::size_t>(count - done, 1U << 30));
    state.next_out = target + done;
    state.avail_out = room;
    const uInt before = state.avail_in;
    const int status = inflate(&state, Z_NO_FLUSH);
    const std::size_t made = room - state.avail_out;
    done += made;
    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    if (status == Z_STREAM_END) {
      inflater_->ended = true;
    } else if (status != Z_OK && status != Z_BUF_ERROR) {
      file_.fail(std::string("is damaged: its gzip data are invalid") +
                 (state.msg != nullptr ? std::string(": ") + state.msg : std::string()));
    } else if (made == 0 && state.avail_in == before && left_ == 0) {
      file_.fail("is truncated: its gzip data end too early");
    }
  }
  return done;
}

void ByteStream::read(void* data, std::size_t count) {
  if (read_some(data, count) < count) {
    file_.fail("is truncated: it ends in the middle of its data");
  }
}

void ByteStream::skip(std::uint64_t count) {
  if (!inflater_) {
    if (count > left_) file_.fail("is truncated: it ends in the middle of its data");
    left_ -= count;
    return file_.skip(count);
  }
  std::vector<unsigned char> block(std::min<std::uint64_t>(kBlock, count));
  while (count > 0) {
    const std::size_t part = std::min<std::uint64_t>(block.size(), count);
    read(block.data(), part);
    count -= part;
  }
}

void ByteStream::expect_end() {
  if (!inflater_) {
    if (left_ == 0) return;
    file_.fail("is too long: there are " + std::to_string(left_) + " bytes behind its data");
  }
  unsigned char more = 0;
  if (read_some(&more, 1) != 0) file_.fail("is too long: there are bytes behind its data");
}

}  // namespace ccvt::io
