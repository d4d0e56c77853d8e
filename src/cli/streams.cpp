#include "cli/streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "ccvt/io.h"
#include "cli/standard_streams.h"

namespace ccvt::cli {

void fill_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest number that is free: this one. The wrong way round, so that its use fails.
    [[maybe_unused]] const int opened =
        ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void print(const std::string& text) {
  const bool taken = standard_output_is_taken();
  std::FILE* const stream = taken ? stderr : stdout;
  if (std::fwrite(text.data(), 1, text.size(), stream) == text.size() && std::fflush(stream) == 0) {
    return;
  }
  if (!taken) fail_to_print();
}

void fail_to_print() {
  throw IoError("standard output: cannot be written: " + std::generic_category().message(errno));
}

}  // namespace ccvt::cli
