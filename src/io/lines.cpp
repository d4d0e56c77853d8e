#include "io/lines.h"

#include <algorithm>
#include <utility>

namespace ccvt::io {

namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;
constexpr std::size_t kLongestLine = std::size_t{64} << 20;

}  // namespace

Lines::Lines(const std::filesystem::path& path, std::string kind)
    : file_(path), kind_(std::move(kind)), buffer_(kBlock) {}

bool Lines::next(std::string_view& line) {
  std::size_t searched = begin_;
  for (;;) {
    const std::size_t at = std::string_view(buffer_.data(), end_).find('\n', searched);
    if (at != std::string_view::npos) {
      line = {buffer_.data() + begin_, at - begin_};
      begin_ = at + 1;
      ++number_;
      return true;
    }
    std::copy(buffer_.data() + begin_, buffer_.data() + end_, buffer_.data());
    end_ -= begin_;
    begin_ = 0;
    searched = end_;
    if (end_ == buffer_.size()) {
      if (end_ >= kLongestLine) {
        ++number_;
        fail("is longer than 64 MiB; this is not " + kind_);
      }
      buffer_.resize(2 * buffer_.size());
    }
    const std::size_t got = file_.read_some(buffer_.data() + end_, buffer_.size() - end_);
    end_ += got;
    if (got == 0) {
      if (end_ == 0) return false;
      line = {buffer_.data(), end_};
      begin_ = end_;
      ++number_;
      return true;
    }
  }
}

std::uint64_t Lines::count_left() {
  std::uint64_t lines = 0;
  bool ended = true;
  while (end_ > begin_) {
    const std::string_view left(buffer_.data() + begin_, end_ - begin_);
    lines += static_cast<std::uint64_t>(std::count(left.begin(), left.end(), '\n'));
    ended = left.back() == '\n';
    begin_ = 0;
    end_ = file_.read_some(buffer_.data(), buffer_.size());
  }
  return lines + (ended ? 0U : 1U);
}

void Lines::fail(const std::string& message) const {
  file_.fail("line " + std::to_string(number_) + ": " + message);
}

}  // namespace ccvt::io
