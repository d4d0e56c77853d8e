#include "support/process.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <iterator>
#include <sstream>

#include "support/files.h"

namespace ccvt::test {

namespace {

std::filesystem::path temporary_file() {
  std::string name = (std::filesystem::temp_directory_path() / "ccvt-out-XXXXXX").string();
  ::close(::mkstemp(name.data()));
  return name;
}

}  // namespace

Process::Process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                 const std::filesystem::path& directory, const std::function<void()>& before)
    : output_(temporary_file()), errors_(temporary_file()) {
  std::vector<std::string> words = {program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  id_ = ::fork();
  if (id_ != 0) return;
  const int output = ::open(output_.c_str(), O_WRONLY);
  const int errors = ::open(errors_.c_str(), O_WRONLY);
  if (::dup2(output, STDOUT_FILENO) < 0 || ::dup2(errors, STDERR_FILENO) < 0) ::_exit(126);
  if (::chdir(directory.c_str()) != 0) ::_exit(126);
  if (before) before();
  ::execv(pointers[0], pointers.data());
  ::_exit(127);
}

Process::~Process() {
  if (id_ > 0 && running()) {
    send(SIGKILL);
    wait();
  }
  std::error_code ignored;
  std::filesystem::remove(output_, ignored);
  std::filesystem::remove(errors_, ignored);
}

void Process::send(int signal) const {
  if (id_ > 0) ::kill(id_, signal);
}

bool Process::running() {
  if (status_ < 0 && ::waitpid(id_, &status_, WNOHANG) == 0) status_ = -1;
  return status_ < 0;
}

int Process::wait() {
  if (status_ < 0) ::waitpid(id_, &status_, 0);
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : 1000 + WTERMSIG(status_);
}

std::string Process::output() const { return get(output_); }
std::string Process::errors() const { return get(errors_); }

#ifdef CCVT_PROGRAM
std::vector<std::string> words(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

Ran run(const TemporaryDirectory& directory, const std::vector<std::string>& arguments,
        const std::function<void()>& before) {
  Process process(CCVT_PROGRAM, arguments, directory.path(), before);
  const int status = process.wait();
  return {status, process.output(), process.errors()};
}

Ran run(const TemporaryDirectory& directory, const std::string& line,
        const std::function<void()>& before) {
  return run(directory, words(line), before);
}
#endif

}  // namespace ccvt::test
