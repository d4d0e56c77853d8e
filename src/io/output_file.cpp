#include "io/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "ccvt/io.h"

namespace ccvt {

std::filesystem::path temporary_path(const std::filesystem::path& target) {
  std::string name = ".";
  name += target.filename().string();
  name += ".ccvt-" + std::to_string(::getpid()) + ".part";
  return target.parent_path() / name;
}

namespace io {

OutputFile::OutputFile(std::filesystem::path target)
    : target_(std::move(target)), temporary_(temporary_path(target_)) {
  std::error_code error;
  if (std::filesystem::is_directory(target_, error)) fail(EISDIR);
  if (std::filesystem::exists(target_, error) &&
      !std::filesystem::is_regular_file(target_, error)) {
    throw IoError(target_.string() + ": cannot be written: is not a regular file");
  }
  // Renaming would replace a file that its owner made read-only.
  if (std::filesystem::exists(target_, error) && ::access(target_.c_str(), W_OK) != 0) fail(errno);
  // Exclusive: neither a link planted under that name nor another writer's file is written to.
  file_ = std::fopen(temporary_.c_str(), "wbx");
  if (file_ == nullptr && errno == EEXIST) {
    std::filesystem::remove(temporary_, error);
    file_ = std::fopen(temporary_.c_str(), "wbx");
  }
  if (file_ == nullptr) fail(errno);
}

OutputFile::~OutputFile() {
  if (file_ == nullptr && temporary_.empty()) return;
  if (file_ != nullptr) std::fclose(file_);
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void OutputFile::write(const void* data, std::size_t count) {
  if (std::fwrite(data, 1, count, file_) < count) fail(errno);
}

void OutputFile::commit() {
  const int closed = std::fclose(std::exchange(file_, nullptr));
  if (closed != 0) fail(errno);
  std::error_code error;
  std::filesystem::rename(temporary_, target_, error);
  if (error) fail(error.value());
  temporary_.clear();
}

void OutputFile::fail(int error) const {
  throw IoError(target_.string() +
                ": cannot be written: " + std::generic_category().message(error));
}

}  // namespace io
}  // namespace ccvt
