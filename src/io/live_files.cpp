#include "io/live_files.h"

#include <cstring>

#include "ccvt/publication.h"

namespace ccvt {

namespace io {

std::atomic<LiveFile*> LiveFile::first_ = nullptr;

static_assert(std::atomic<LiveFile*>::is_always_lock_free &&
                  std::atomic<pid_t>::is_always_lock_free,
              "signal handlers may use no locks");

LiveFile* LiveFile::enter(const std::string& path) {
  if (path.size() >= kLongestPath) return nullptr;
  LiveFile* file = first_.load();
  for (; file != nullptr; file = file->next_) {
    bool taken = false;
    if (file->taken_.compare_exchange_strong(taken, true)) break;
  }
  const bool is_new = file == nullptr;
  if (is_new) file = new LiveFile;  // never deleted: a handler may be looking at it
  std::memcpy(file->path_.data(), path.c_str(), path.size() + 1);
  file->owner_.store(::getpid());
  if (is_new) {
    file->next_ = first_.load();
    while (!first_.compare_exchange_weak(file->next_, file)) {
    }
  }
  return file;
}

void LiveFile::leave() noexcept {
  owner_.store(0);
  taken_.store(false);
}

void LiveFile::unlink_all() noexcept {
  const pid_t self = ::getpid();
  for (const LiveFile* file = first_.load(); file != nullptr; file = file->next_) {
    if (file->owner_.load() == self) ::unlink(file->path_.data());
  }
}

}  // namespace io

void remove_unfinished_files() noexcept { io::LiveFile::unlink_all(); }

}  // namespace ccvt
