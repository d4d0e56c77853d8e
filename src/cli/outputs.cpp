#include "cli/outputs.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <system_error>

#include "cli/signals.h"
#include "cli/standard_streams.h"
#include "io/formats.h"

namespace ccvt::cli {

namespace {

namespace fs = std::filesystem;

void check_extension(const fs::path& path, io::Extensions allowed) {
  const std::string extension = io::extension_of(path);
  if (allowed.empty() || io::is_among(allowed, extension)) return;
  std::error_code error;
  if (extension.empty() && fs::is_directory(path, error)) {
    throw InvalidInput(path.string() + ": is a directory; must be a file with the extension " +
                       io::list_of(allowed, " or "));
  }
  throw InvalidInput(path.string() + ": unknown extension '" + extension + "'; must be " +
                     io::list_of(allowed, " or "));
}

/// Where `path` leads, through links, whether it is there or not.
fs::path destination(const fs::path& path) {
  std::error_code error;
  const fs::path target = check_before([&] { return output_target(path); });
  return fs::weakly_canonical(fs::absolute(target, error), error);
}

/// Throws when shells have been told to write there what the program prints.
void check_no_stream(const std::string& option, const fs::path& path) {
  struct stat file = {};
  if (::stat(path.c_str(), &file) != 0 || !S_ISREG(file.st_mode)) return;
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat other = {};
    if (::fstat(stream, &other) != 0) continue;
    if (other.st_dev != file.st_dev || other.st_ino != file.st_ino) continue;
    throw InvalidInput(path.string() + ": " + option + " names the file that standard " +
                       (stream == STDOUT_FILENO ? "output" : "error") + " goes to");
  }
}

}  // namespace

Outputs& Outputs::add(const std::string& option, const fs::path& path, io::Extensions extensions) {
  if (!path.empty()) files_.push_back({option, path, extensions, false});
  return *this;
}

Outputs& Outputs::add_input(const std::string& option, const fs::path& path) {
  if (!path.empty()) files_.push_back({option, path, {}, true});
  return *this;
}

void Outputs::check() const {
  for (const File& file : files_) {
    if (file.input) continue;
    check_extension(file.path, file.extensions);
    for (const File& other : files_) {
      if (&other == &file) continue;
      std::error_code error;
      if (fs::equivalent(file.path, other.path, error) ||
          (!other.input && destination(file.path) == destination(other.path))) {
        throw InvalidInput(file.path.string() + ": " + file.option + " and " + other.option +
                           " name the same file; they must differ");
      }
    }
    check_no_stream(file.option, file.path);
  }
  probe();
  receive_standard_input();
}

void Outputs::probe() const {
  // Written, but never published: what else would tell for sure.
  const Publication unpublished;
  for (const File& file : files_) {
    if (!file.input) check_before([&] { write_text(file.path, ""); });
  }
}

int publish(Publication& outputs) {
  const int status = interrupted() ? 130 : 0;  // what comes later changes nothing that is written
  // The only copy that may fail late, or wait for who reads it.
  send_standard_output(outputs);
  const EndsHeldBack until_done;
  outputs.publish();
  return status;
}

}  // namespace ccvt::cli
