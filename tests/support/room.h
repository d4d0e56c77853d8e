#pragma once

#include <stdlib.h>

#include <cstddef>
#include <filesystem>
#include <iterator>

#include "support/files.h"

namespace ccvt::test {

/// A directory to work in, and in it one for temporary files, which is where stand-ins for streams
/// are.
struct Room {
  Room() { std::filesystem::create_directory(directory / "tmp"); }
  /// Makes it that of a process.
  void enter() const { ::setenv("TMPDIR", (directory / "tmp").c_str(), 1); }
  /// How many temporary files there are.
  [[nodiscard]] std::size_t left() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(directory / "tmp"), {}));
  }
  TemporaryDirectory directory;
};

}  // namespace ccvt::test
