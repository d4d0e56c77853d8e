#include "cli/outputs.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "ccvt/io.h"
#include "cli/signals.h"

namespace ccvt::cli {

namespace {

namespace fs = std::filesystem;

void check_extension(const fs::path& path, io::Extensions allowed) {
  const std::string extension = lower_extension(path);
  if (allowed.empty() || io::is_among(allowed, extension)) return;
  throw InvalidInput(path.string() + ": unknown extension '" + extension + "'; must be " +
                     io::list_of(allowed, " or "));
}

/// Creates and removes the temporary file: what else would tell for sure.
void check_writable(const fs::path& path) {
  const fs::path directory = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const auto fail = [&](const std::string& reason) {
    throw IoError(path.string() + ": cannot be written: " + reason);
  };
  std::error_code error;
  if (!fs::is_directory(directory, error)) {
    fail("there is no directory '" + directory.string() + "'");
  }
  if (fs::is_directory(path, error)) fail("is a directory");
  if (fs::exists(path, error) && !fs::is_regular_file(path, error)) fail("is not a regular file");
  if (fs::exists(path, error) && ::access(path.c_str(), W_OK) != 0) {
    fail(std::generic_category().message(errno));
  }
  const fs::path temporary = temporary_path(path);
  fs::remove(temporary, error);
  std::FILE* const file = std::fopen(temporary.c_str(), "wbx");
  if (file == nullptr) fail(std::generic_category().message(errno));
  std::fclose(file);
  fs::remove(temporary, error);
}

}  // namespace

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return extension;
}

Outputs& Outputs::add(const std::string& option, const fs::path& path, io::Extensions extensions) {
  if (!path.empty()) files_.push_back({option, path, extensions, false});
  return *this;
}

Outputs& Outputs::add_input(const std::string& option, const fs::path& path) {
  if (!path.empty()) files_.push_back({option, path, {}, true});
  return *this;
}

void Outputs::check() const {
  std::vector<fs::path> outputs;
  for (const File& file : files_) {
    if (file.input) continue;
    if (file.path == "-")
      throw InvalidInput(file.option + ": '-' is no file; standard output is not written to");
    check_extension(file.path, file.extensions);
    for (const File& other : files_) {
      if (&other == &file) continue;
      std::error_code error;
      if (fs::equivalent(file.path, other.path, error) ||
          fs::weakly_canonical(fs::absolute(file.path, error), error) ==
              fs::weakly_canonical(fs::absolute(other.path, error), error)) {
        throw InvalidInput(file.path.string() + ": " + file.option + " and " + other.option +
                           " name the same file; they must differ");
      }
    }
    outputs.push_back(file.path);
  }
  protect_outputs(outputs);
  for (const auto& output : outputs) check_writable(output);
}

}  // namespace ccvt::cli
