#include "io/unfinished_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <random>
#include <system_error>
#include <utility>

#include "ccvt/io.h"
#include "io/live_files.h"

namespace ccvt {

namespace fs = std::filesystem;

namespace {

constexpr int kMostLinks = 40;  // as Linux has it

/// ".ccvt-0123456789abcdef.part"
std::string random_name() {
  std::random_device device;
  const std::uint64_t number = std::uint64_t{device()} << 32U | device();
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(number));
  return std::string(".ccvt-") + digits.data() + ".part";
}

[[noreturn]] void fail_to_write(const fs::path& target, const std::string& reason) {
  throw IoError(target.string() + ": cannot be written: " + reason);
}

void sync_directory(const fs::path& directory) {
  const char* const name = directory.empty() ? "." : directory.c_str();
  const int descriptor = ::open(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

/// So that a change of the working directory does no harm; as it is where there is no other way.
fs::path absolute_if_possible(const fs::path& path) {
  std::error_code error;
  fs::path absolute = fs::absolute(path, error);
  return error ? path : absolute;
}

}  // namespace

fs::path output_target(const fs::path& path) {
  fs::path file = path;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(file, error)); ++links) {
    if (links == kMostLinks) fail_to_write(path, std::generic_category().message(ELOOP));
    const fs::path next = fs::read_symlink(file, error);
    if (error) fail_to_write(path, error.message());
    file = file.parent_path() / next;  // where an absolute one replaces all
  }
  return file;
}

namespace io {

UnfinishedFile::UnfinishedFile(fs::path target) : target_(std::move(target)) {
  const int permissions = check_target();
  const fs::path file = output_target(target_);
  if (!file.has_filename()) fail(EISDIR);
  final_ = absolute_if_possible(file);
  create(file.has_parent_path() ? file.parent_path() : fs::path("."), permissions);
}

UnfinishedFile::UnfinishedFile(UnfinishedFile&& other) noexcept
    : target_(std::move(other.target_)),
      final_(std::move(other.final_)),
      path_(std::move(other.path_)),
      live_(std::exchange(other.live_, nullptr)),
      descriptor_(std::exchange(other.descriptor_, -1)) {
  other.path_.clear();
}

UnfinishedFile::~UnfinishedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!path_.empty()) ::unlink(path_.c_str());
  drop();
}

void UnfinishedFile::drop() noexcept {
  path_.clear();
  if (live_ != nullptr) std::exchange(live_, nullptr)->leave();
}

int UnfinishedFile::check_target() const {
  // The system follows the links first: it knows circles, and links that are not to be trusted.
  struct stat there = {};
  if (::stat(target_.c_str(), &there) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) return -1;
    fail(errno);
  }
  if (S_ISDIR(there.st_mode)) fail_to_write(target_, "is a directory");
  if (!S_ISREG(there.st_mode)) fail_to_write(target_, "is not a regular file");
  // Renaming would replace a file that its owner made read-only.
  if (::access(target_.c_str(), W_OK) != 0) fail(errno);
  // As /proc/self/fd/1 may be. Whether it is still the same file is not asked: another writer may
  // just have replaced it.
  struct stat named = {};
  if (::lstat(output_target(target_).c_str(), &named) != 0) {
    fail_to_write(target_, "is a link to a file that has no name");
  }
  return static_cast<int>(there.st_mode & 0777U);
}

void UnfinishedFile::create(const fs::path& directory, int permissions) {
  const fs::path parent = final_.parent_path();
  // As nobody may read the old file, so with the new one, from its first moment.
  const mode_t mode = permissions < 0 ? 0666 : 0600;
  int error = EEXIST;
  while (descriptor_ < 0 && error == EEXIST) {
    fs::path path = parent / random_name();
    live_ = LiveFile::enter(path.string());
    descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    error = errno;
    if (descriptor_ >= 0) {
      path_ = std::move(path);
    } else {
      drop();
    }
  }
  if (descriptor_ < 0) {
    std::error_code ignored;
    if ((error == ENOENT || error == ENOTDIR) && !fs::is_directory(directory, ignored)) {
      fail_to_write(target_, "there is no directory '" + directory.string() + "'");
    }
    fail(error);
  }
  // Where the file system has no such permissions, the old file had none either.
  if (permissions >= 0) {
    [[maybe_unused]] const int kept = ::fchmod(descriptor_, static_cast<mode_t>(permissions));
  }
}

int UnfinishedFile::take_descriptor() { return std::exchange(descriptor_, -1); }

void UnfinishedFile::publish() {
  if (std::rename(path_.c_str(), final_.c_str()) != 0) fail(errno);
  drop();
}

void UnfinishedFile::keep_name() const { sync_directory(final_.parent_path()); }

void UnfinishedFile::fail(int error) const {
  fail_to_write(target_, std::generic_category().message(error));
}

}  // namespace io
}  // namespace ccvt
