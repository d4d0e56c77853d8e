#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/publication.h"
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

  /// Throws InvalidInput unless all extensions are allowed, all files are different, whatever links
  /// lead to them, and all outputs can be written. Then reads standard input, if it is a file.
  void check() const;

 private:
  void probe() const;

  struct File {
    std::string option;
    std::filesystem::path path;
    io::Extensions extensions;
    bool input = false;
  };
  std::vector<File> files_;
};

/// Calls `check`, before the run: an IoError is the user's mistake then, and becomes InvalidInput.
template <class Check>
decltype(auto) check_before(Check&& check) {
  try {
    return std::forward<Check>(check)();
  } catch (const IoError& error) {
    throw InvalidInput(error.what());
  }
}

/// Sends what is for standard output there, then publishes all other outputs of a run. A signal
/// that ends the program waits until the latter is done. Returns the status of the run: 130 when it
/// had been interrupted by then, else 0. Throws IoError; where standard output fails, before any
/// file has been replaced.
int publish(Publication& outputs);

}  // namespace ccvt::cli
