#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

#include "io/unfinished_file.h"

namespace ccvt::io {

/// A file that appears under its name only when it is complete and on its disk: written under
/// another name, then renamed. Unless committed, the destructor removes it.
class OutputFile {
 public:
  /// Throws IoError when the file cannot be created.
  explicit OutputFile(std::filesystem::path target);

  /// Throws IoError.
  void write(const void* data, std::size_t count);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// Completes the file, and renames it, unless a Publication of this thread is to do that. Throws
  /// IoError.
  void commit();
  /// The same, and no Publication is asked.
  void commit_now();

 private:
  void synchronize();
  void close();

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  UnfinishedFile unfinished_;
  std::unique_ptr<std::FILE, Close> file_;
  std::size_t unsynchronized_ = 0;
};

}  // namespace ccvt::io
