#include "cli/signals.h"

#include <time.h>  // NOLINT(modernize-deprecated-headers): <ctime> lacks POSIX's clock_gettime()
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <cstring>
#include <string>

#include "ccvt/io.h"

namespace ccvt::cli {

namespace {

constexpr std::size_t kMostOutputs = 5;
constexpr std::size_t kLongestPath = 4096;

// Read by the handler, which may call but few functions and allocate nothing. The temporary names
// are known before the files exist; unlinking one that does not exist is harmless.
char temporary_names[kMostOutputs][kLongestPath];
volatile std::sig_atomic_t temporary_count = 0;
volatile std::sig_atomic_t interrupt_count = 0;
volatile std::sig_atomic_t somebody_reads = 0;  // standard error is a terminal
double interrupted_at = 0;                      // read and written by the handler alone

void remove_temporary_files() {
  for (int i = 0; i < temporary_count; ++i) ::unlink(temporary_names[i]);
}

double seconds_now() {
  timespec now = {};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

extern "C" void on_interrupt(int) {
  // One Ctrl-C may arrive twice: a parent that passes it on signals the process and its group.
  constexpr double kSameKey = 0.3;
  const double now = seconds_now();
  if (interrupt_count == 0) {
    interrupt_count = 1;
    interrupted_at = now;
    constexpr char message[] =
        "\nccvt: stopping, and writing what has been reached; Ctrl-C again discards it\n";
    if (somebody_reads != 0) {
      [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message, sizeof message - 1);
    }
    return;
  }
  if (now - interrupted_at < kSameKey) return;
  remove_temporary_files();
  ::_exit(130);
}

extern "C" void on_termination(int signal) {
  remove_temporary_files();
  ::_exit(128 + signal);
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
  somebody_reads = ::isatty(STDERR_FILENO) != 0 ? 1 : 0;
  handle(SIGINT, on_interrupt);
  handle(SIGTERM, on_termination);
  if (!is_ignored(SIGHUP)) handle(SIGHUP, on_termination);  // as nohup asks
}

bool interrupted() { return interrupt_count != 0; }

void protect_outputs(const std::vector<std::filesystem::path>& outputs) {
  temporary_count = 0;  // a name that is being written is not read
  int count = 0;
  for (const auto& output : outputs) {
    const std::string name = temporary_path(output).string();
    if (count == static_cast<int>(kMostOutputs) || name.size() >= kLongestPath) continue;
    std::memcpy(temporary_names[count], name.c_str(), name.size() + 1);
    temporary_count = ++count;
  }
}

}  // namespace ccvt::cli
