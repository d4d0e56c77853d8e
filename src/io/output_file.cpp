#include "io/output_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "io/publication.h"

namespace ccvt::io {

namespace {

/// So much is on its way to the disk at most: nobody can stop a process that waits for it.
constexpr std::size_t kMostUnsynchronized = std::size_t{1} << 24;

}  // namespace

OutputFile::OutputFile(std::filesystem::path target) : unfinished_(std::move(target)) {
  const int descriptor = unfinished_.take_descriptor();
  file_.reset(::fdopen(descriptor, "wb"));
  if (!file_) {
    const int error = errno;
    ::close(descriptor);
    unfinished_.fail(error);
  }
}

void OutputFile::write(const void* data, std::size_t count) {
  const char* bytes = static_cast<const char*>(data);
  while (count > 0) {
    const std::size_t part = std::min(count, kMostUnsynchronized - unsynchronized_);
    if (std::fwrite(bytes, 1, part, file_.get()) < part) unfinished_.fail(errno);
    bytes += part;
    count -= part;
    unsynchronized_ += part;
    if (unsynchronized_ == kMostUnsynchronized) synchronize();
  }
}

void OutputFile::synchronize() {
  if (std::fflush(file_.get()) != 0) unfinished_.fail(errno);
  // Some file systems have nothing to synchronize with.
  if (::fsync(::fileno(file_.get())) != 0 && errno != EINVAL && errno != ENOSYS) {
    unfinished_.fail(errno);
  }
  unsynchronized_ = 0;
}

void OutputFile::close() {
  synchronize();
  if (std::fclose(file_.release()) != 0) unfinished_.fail(errno);
}

void OutputFile::commit() {
  close();
  publish(std::move(unfinished_));
}

void OutputFile::commit_now() {
  close();
  unfinished_.publish();
  unfinished_.keep_name();
}

}  // namespace ccvt::io
