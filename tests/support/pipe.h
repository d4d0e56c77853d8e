#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace ccvt::test {

/// A pipe to or from a program, which has only what its `before` makes a standard stream. Writing
/// where nobody reads fails while one lives.
class Pipe {
 public:
  Pipe() : broken_(std::signal(SIGPIPE, SIG_IGN)) {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) throw std::runtime_error("there are no pipes");
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    close_reading();
    close_writing();
    std::signal(SIGPIPE, broken_);
  }

  [[nodiscard]] int reading() const { return ends_[0]; }
  [[nodiscard]] int writing() const { return ends_[1]; }
  /// How many bytes it holds at most.
  [[nodiscard]] std::size_t capacity() const {
    return static_cast<std::size_t>(::fcntl(writing(), F_GETPIPE_SZ));
  }
  void close_reading() { close(ends_[0]); }
  void close_writing() { close(ends_[1]); }

  /// False when nobody reads it to the end.
  [[nodiscard]] bool write(const std::string& bytes) const {
    return ::write(writing(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  }
  /// All up to the end, which comes when nobody has the other end open.
  [[nodiscard]] std::string read() const {
    std::string text;
    std::array<char, 4096> block;
    for (;;) {
      const ssize_t got = ::read(reading(), block.data(), block.size());
      if (got <= 0) return text;
      text.append(block.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  static void close(int& end) {
    if (end >= 0) ::close(std::exchange(end, -1));
  }

  std::array<int, 2> ends_{};
  void (*broken_)(int);
};

}  // namespace ccvt::test
