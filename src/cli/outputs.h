#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/formats.h"

namespace ccvt::cli {

/// The files that a run is going to write, checked before it starts.
class Outputs {
 public:
  /// `option` is how the user named the file. `extensions`: those allowed, of which none means
  /// any. An empty path is no output.
  Outputs& add(const std::string& option, const std::filesystem::path& path,
               io::Extensions extensions = {});
  /// A file that is read, and must not be written.
  Outputs& add_input(const std::string& option, const std::filesystem::path& path);

  /// Throws InvalidInput or IoError unless all extensions are allowed, all files are different, and
  /// all can be written. Then hands them to protect_outputs().
  void check() const;

 private:
  struct File {
    std::string option;
    std::filesystem::path path;
    io::Extensions extensions;
    bool input = false;
  };
  std::vector<File> files_;
};

/// The extension in lower case.
std::string lower_extension(const std::filesystem::path& path);

}  // namespace ccvt::cli
