#include "io/input_file.h"

#include <sys/types.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "ccvt/io.h"

namespace ccvt::io {

std::string quoted(std::string_view text) {
  constexpr std::size_t longest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, longest)) result += c >= ' ' && c <= '~' ? c : '?';
  if (text.size() > longest) result += "...";
  return result + "'";
}

InputFile::InputFile(const std::filesystem::path& path) : name_(path.string()) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) fail("there is no such file");
  if (error) throw IoError(name_ + ": cannot be opened: " + error.message());
  if (status.type() == std::filesystem::file_type::directory) fail("is a directory, not a file");
  if (status.type() != std::filesystem::file_type::regular) fail("is not a regular file");
  file_.reset(std::fopen(path.c_str(), "rb"));
  if (!file_) {
    throw IoError(name_ + ": cannot be opened: " + std::generic_category().message(errno));
  }
  size_ = std::filesystem::file_size(path, error);
  if (error) throw IoError(name_ + ": its size is unknown: " + error.message());
  if (size_ == 0) fail("is empty");
}

std::size_t InputFile::read_some(void* data, std::size_t count) {
  const std::size_t got = std::fread(data, 1, count, file_.get());
  if (got < count && std::ferror(file_.get()) != 0) {
    throw IoError(name_ + ": cannot be read: " + std::generic_category().message(errno));
  }
  return got;
}

void InputFile::skip(std::uint64_t count) { move(count, SEEK_CUR); }

void InputFile::go_to(std::uint64_t position) { move(position, SEEK_SET); }

void InputFile::move(std::uint64_t count, int from) {
  if (::fseeko(file_.get(), static_cast<off_t>(count), from) == 0) return;
  throw IoError(name_ + ": cannot be read: " + std::generic_category().message(errno));
}

void InputFile::read(void* data, std::size_t count) {
  if (read_some(data, count) < count) fail("is truncated: it ends in the middle of its data");
}

void InputFile::fail(const std::string& message) const {
  throw InvalidInput(name_ + ": " + message);
}

}  // namespace ccvt::io
