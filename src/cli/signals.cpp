#include "cli/signals.h"

#include <time.h>  // NOLINT(modernize-deprecated-headers): <ctime> lacks POSIX's clock_gettime()
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "ccvt/publication.h"

namespace ccvt::cli {

namespace {

// Read and written by handlers, on any thread.
std::atomic<bool> watched = false;
std::atomic<bool> somebody_reads = false;      // standard error is a terminal
std::atomic<std::int64_t> interrupted_at = 0;  // nanoseconds; 0: not interrupted
std::atomic<bool> held_back = false;
std::atomic<int> held_signal = 0;
std::atomic<bool> ends_asked = false;
std::atomic<int> asked_signal = 0;
/// A name that a handler can read at any moment.
struct Name {
  std::array<char, 4096> text = {};
  std::atomic<bool> whole = false;

  void set(const std::string& name) {
    whole = false;  // a name that is being written is not read
    if (name.empty() || name.size() >= text.size()) return;
    std::memcpy(text.data(), name.c_str(), name.size() + 1);
    whole = true;
  }
};
Name directory_to_remove;
std::array<Name, 2> files_to_remove;
Name mapped_file;
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

std::int64_t now() {
  timespec time = {};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

void say(std::string_view text) {
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
}

[[noreturn]] void leave_with(int status) {
  remove_unfinished_files();
  for (const Name& file : files_to_remove) {
    if (file.whole) ::unlink(file.text.data());
  }
  if (directory_to_remove.whole) ::rmdir(directory_to_remove.text.data());
  ::_exit(status);
}

[[noreturn]] void leave(int signal) { leave_with(128 + signal); }

/// Where a page of a mapped file is beyond the end that the file has by now, or cannot be read.
extern "C" void on_lost_page(int signal, siginfo_t* info, void* /*context*/) {
  if (info->si_code != BUS_ADRERR) {
    // Not of a mapped file: what happens without a handler, when the instruction is tried again.
    ::signal(signal, SIG_DFL);
    return;
  }
  say("ccvt: error: ");
  say(mapped_file.whole ? std::string_view(mapped_file.text.data()) : "a file");
  say(": cannot be read any more: it became shorter while it was read, or its disk fails\n");
  leave_with(1);
}

extern "C" void on_termination(int signal) {
  if (held_back) {
    held_signal = signal;
    return;
  }
  int none = 0;
  if (ends_asked && asked_signal.compare_exchange_strong(none, signal)) {
    interrupted_at = now();
    return;
  }
  leave(signal);
}

extern "C" void on_interrupt(int signal) {
  const int error = errno;  // of what was interrupted
  // One Ctrl-C may arrive twice: a parent that passes it on signals the process and its group.
  constexpr std::int64_t same_key = 300'000'000;
  const std::string_view line = somebody_reads ? "\n" : "";  // behind what shows the progress
  const std::int64_t time = now();
  std::int64_t before = 0;
  if (watched && interrupted_at.compare_exchange_strong(before, time)) {
    if (somebody_reads) {
      say("\nccvt: stopping, and writing what has been reached; Ctrl-C again discards it\n");
    }
    errno = error;
    return;
  }
  if (watched && time - before < same_key) return;
  if (!held_back) {
    say(line);
    say(watched ? "ccvt: error: interrupted again: what had been reached is discarded\n"
                : "ccvt: error: interrupted before there was anything to write\n");
  }
  on_termination(signal);
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  ::sigaction(signal, &action, nullptr);
}

bool is_ignored(int signal) {
  struct sigaction action = {};
  return ::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

void handle_signals() {
  somebody_reads = ::isatty(STDERR_FILENO) != 0;
  handle(SIGINT, on_interrupt);
  handle(SIGTERM, on_termination);
  for (const int signal : {SIGHUP, SIGQUIT, SIGXCPU}) {
    if (!is_ignored(signal)) handle(signal, on_termination);  // as nohup and shells ask
  }
  handle(SIGXFSZ, SIG_IGN);
  handle(SIGPIPE, SIG_IGN);
}

void tell_if_cut_short(const std::filesystem::path& file) {
  mapped_file.set(file.string());
  struct sigaction action = {};
  action.sa_sigaction = on_lost_page;
  action.sa_flags = SA_SIGINFO;
  ::sigemptyset(&action.sa_mask);
  ::sigaction(SIGBUS, &action, nullptr);
}

std::function<bool()> watch_interrupts() {
  watched = true;
  return [] { return interrupted(); };
}

bool interrupted() { return interrupted_at != 0; }

void interrupt_too() {
  std::int64_t before = 0;
  interrupted_at.compare_exchange_strong(before, now());
}

EndsHeldBack::EndsHeldBack() { held_back = true; }

EndsHeldBack::~EndsHeldBack() {
  held_back = false;
  if (held_signal != 0) leave(held_signal);
}

EndsAsked::EndsAsked() { ends_asked = true; }

EndsAsked::~EndsAsked() { ends_asked = false; }

int EndsAsked::signal() { return asked_signal; }

SignalsBlocked::SignalsBlocked() {
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, &before_);
}

SignalsBlocked::~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

void unlink_at_end(std::size_t slot, const std::filesystem::path& file) {
  files_to_remove.at(slot).set(file.string());
}

void remove_at_end(const std::filesystem::path& directory) {
  directory_to_remove.set(directory.string());
}

}  // namespace ccvt::cli
