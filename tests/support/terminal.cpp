#include "support/terminal.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace ccvt::test {

#ifdef CCVT_PROGRAM
Ran run_on_terminal(const TemporaryDirectory& directory, const std::string& line,
                    const Terminal& terminal) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0) {
    throw std::runtime_error("there are no pseudoterminals");
  }
  const std::string name = ::ptsname(master);
  const int slave = ::open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  std::vector<std::string> environment = terminal.environment;
  Process process(CCVT_PROGRAM, words(line), directory.path(), [&] {
    ::dup2(slave, STDERR_FILENO);
    if (terminal.output) ::dup2(slave, STDOUT_FILENO);
    for (std::string& variable : environment) ::putenv(variable.data());
  });
  ::close(slave);
  std::string text;
  std::array<char, 4096> block;
  for (;;) {  // the end comes when nobody has the terminal open any more
    const ssize_t got = ::read(master, block.data(), block.size());
    if (got <= 0) break;
    text.append(block.data(), static_cast<std::size_t>(got));
  }
  ::close(master);
  return {process.wait(), process.output(), text};
}
#endif

}  // namespace ccvt::test
