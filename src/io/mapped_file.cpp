#include "io/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "ccvt/io.h"

namespace ccvt::io {

MappedFile::MappedFile(const std::filesystem::path& path, std::uint64_t size)
    : name_(path.string()), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)), size_(size) {
  try {
    if (file_ < 0) {
      throw IoError(name_ + ": cannot be read: " + std::generic_category().message(errno));
    }
    modified_ = status().st_mtim;
    check_unchanged();
    void* const data = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file_, 0);
    if (data == MAP_FAILED) {
      throw IoError(name_ + ": cannot be mapped: " + std::generic_category().message(errno));
    }
    data_ = static_cast<const std::byte*>(data);
  } catch (...) {
    if (file_ >= 0) ::close(file_);
    throw;
  }
}

MappedFile::~MappedFile() {
  // munmap() takes no pointer to const, and writes nothing.
  ::munmap(const_cast<std::byte*>(data_), size_);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
  ::close(file_);
}

struct stat MappedFile::status() const {
  struct stat now = {};
  if (::fstat(file_, &now) != 0) {
    throw IoError(name_ + ": cannot be read: " + std::generic_category().message(errno));
  }
  return now;
}

void MappedFile::check_unchanged() const {
  const struct stat now = status();
  const bool same = std::cmp_equal(now.st_size, size_) && now.st_mtim.tv_sec == modified_.tv_sec &&
                    now.st_mtim.tv_nsec == modified_.tv_nsec;
  if (!same) throw InvalidInput(name_ + ": has changed while it was read");
}

}  // namespace ccvt::io
