#pragma once

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <string>

namespace ccvt::io {

/// The name of a file that is to be removed when the process ends before its time. All are in one
/// list that a signal handler can walk at any moment: it only grows, and names are used again.
class LiveFile {
 public:
  /// Enters the name of a file that may, but need not exist yet. Null for a name that is too long.
  static LiveFile* enter(const std::string& path);
  /// Takes the name out of the list.
  void leave() noexcept;
  /// Unlinks all files that this process has entered. Async-signal-safe.
  static void unlink_all() noexcept;

 private:
  static constexpr std::size_t kLongestPath = 4096;

  std::atomic<bool> taken_ = true;
  std::atomic<pid_t> owner_ =
      0;  // 0: there is no name; a child of fork() leaves its parent's files
  std::array<char, kLongestPath> path_ = {};
  LiveFile* next_ = nullptr;

  static std::atomic<LiveFile*> first_;
};

}  // namespace ccvt::io
