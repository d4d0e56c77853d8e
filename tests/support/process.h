#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "support/files.h"

namespace ccvt::test {

/// A program that runs in `directory`, with what it prints.
class Process {
 public:
  /// `before` is called in the new process, right before it becomes the program.
  Process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
          const std::filesystem::path& directory, const std::function<void()>& before = {});
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();

  [[nodiscard]] pid_t id() const { return id_; }
  void send(int signal) const;
  /// False when it has ended.
  bool running();
  /// Waits for the end. The exit status; 1000 and the signal when a signal ended it.
  int wait();
  /// After wait().
  [[nodiscard]] std::string output() const;
  [[nodiscard]] std::string errors() const;

 private:
  std::filesystem::path output_;
  std::filesystem::path errors_;
  pid_t id_ = -1;
  int status_ = -1;
};

#ifdef CCVT_PROGRAM
/// Splits at blanks, as a shell does.
std::vector<std::string> words(const std::string& line);

struct Ran {
  int status;
  std::string output;
  std::string errors;
};

/// Runs the program in `directory` to its end.
Ran run(const TemporaryDirectory& directory, const std::vector<std::string>& arguments,
        const std::function<void()>& before = {});
Ran run(const TemporaryDirectory& directory, const std::string& line,
        const std::function<void()>& before = {});
#endif

}  // namespace ccvt::test
