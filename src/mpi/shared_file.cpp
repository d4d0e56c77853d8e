#include "shared_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "io/npy.h"
#include "io/publication.h"

namespace ccvt::mpi {
namespace {

/// A file that is there, open to be written in parts.
class OpenFile {
 public:
  OpenFile(const std::string& path, const std::filesystem::path& target)
      : target_(target), descriptor_(::open(path.c_str(), O_WRONLY | O_CLOEXEC)) {
    if (descriptor_ >= 0) return;
    throw IoError(target_.string() + ": cannot be opened by all ranks: " + last_error());
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { ::close(descriptor_); }

  /// Until it is on the disk, a part at a time: nobody can stop a process that waits for it.
  void write(std::uint64_t at, std::span<const std::byte> bytes) {
    constexpr std::size_t kMostUnsynchronized = std::size_t{1} << 24;
    while (!bytes.empty()) {
      std::span<const std::byte> part = bytes.first(std::min(bytes.size(), kMostUnsynchronized));
      bytes = bytes.subspan(part.size());
      while (!part.empty()) {
        const ssize_t written =
            ::pwrite(descriptor_, part.data(), part.size(), static_cast<off_t>(at));
        if (written < 0) throw not_written();
        part = part.subspan(static_cast<std::size_t>(written));
        at += static_cast<std::uint64_t>(written);
      }
      // Some file systems have nothing to synchronize with.
      if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOSYS) throw not_written();
    }
  }

 private:
  static std::string last_error() { return std::generic_category().message(errno); }
  [[nodiscard]] IoError not_written() const {
    return IoError(target_.string() + ": cannot be written: " + last_error());
  }

  const std::filesystem::path& target_;
  int descriptor_;
};

}  // namespace

SharedFile::SharedFile(const Session& session, std::filesystem::path target,
                       const std::string& descr, std::uint64_t rows, std::uint64_t columns,
                       std::size_t row_bytes)
    : session_(session), target_(std::move(target)), row_bytes_(row_bytes) {
  std::vector<std::uint64_t> shape = {rows};
  if (columns > 0) shape.push_back(columns);
  const std::string header = io::format_npy_header(descr, shape);
  header_bytes_ = header.size();
  session_.together([&] {
    if (!session_.is_first()) return;
    unfinished_.emplace(target_);
    const int descriptor = unfinished_->take_descriptor();
    const bool written = ::write(descriptor, header.data(), header.size()) == std::ssize(header);
    const int error = errno;
    ::close(descriptor);
    if (!written) unfinished_->fail(error);
    path_ = unfinished_->path().string();
  });
  const std::vector<Ranks::Bytes> paths =
      session_.ranks().gather(std::as_bytes(std::span(std::as_const(path_))));
  path_.assign(reinterpret_cast<const char*>(paths[0].data()), paths[0].size());
}

void SharedFile::write(std::uint64_t first_row, std::span<const std::byte> rows) {
  session_.together([&] {
    if (rows.empty()) return;
    OpenFile(path_, target_).write(header_bytes_ + first_row * row_bytes_, rows);
  });
}

void SharedFile::publish() {
  if (unfinished_) io::publish(std::move(*unfinished_));
}

}  // namespace ccvt::mpi
