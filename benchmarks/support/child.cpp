#include "support/child.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <string>
#include <system_error>

namespace ccvt::bench {
namespace {

[[noreturn]] void fail(const char* call) {
  throw std::system_error(errno, std::generic_category(), call);
}

void write_all(int file, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = ::write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) ::_exit(1);
    done += static_cast<std::size_t>(count);
  }
}

std::string read_all(int file) {
  std::string text;
  std::array<char, 65536> buffer;
  for (;;) {
    const ssize_t count = ::read(file, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

[[noreturn]] void be_child(int file, const std::function<Json()>& work) {
  Json answer;
  try {
    answer["value"] = work();
  } catch (const std::exception& error) {
    answer = {{"error", error.what()}};
  }
  write_all(file, answer.dump());
  // Not exit(): what the parent has in its buffers is not ours to write.
  ::_exit(0);
}

struct Child {
  pid_t id;
  int answer;  ///< what it writes comes here
};

Child start(const std::function<Json()>& work) {
  // Others would not exist in the child, whose pools would wait for them or do without.
  const auto threads = std::filesystem::directory_iterator("/proc/self/task");
  if (std::distance(begin(threads), end(threads)) != 1) {
    throw std::logic_error("benchmark: it must have one thread when it starts a child");
  }
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) fail("pipe");
  std::fflush(nullptr);
#ifdef __GLIBC__
  // What this process has freed, a child would write to again page by page, each a copy.
  ::malloc_trim(0);
#endif
  const pid_t id = ::fork();
  if (id < 0) fail("fork");
  if (id == 0) {
    ::close(pipe[0]);
    be_child(pipe[1], work);
  }
  ::close(pipe[1]);
  return {id, pipe[0]};
}

Json finish(const Child& child) {
  const std::string text = read_all(child.answer);
  ::close(child.answer);
  int status = 0;
  rusage usage{};
  while (::wait4(child.id, &status, 0, &usage) < 0) {
    if (errno != EINTR) fail("wait4");
  }
  if (WIFSIGNALED(status)) {
    throw std::runtime_error("a run was ended by signal " + std::to_string(WTERMSIG(status)));
  }
  Json answer = Json::parse(text, nullptr, false);
  if (answer.is_discarded()) throw std::runtime_error("a run ended without a result");
  if (answer.contains("error")) throw std::runtime_error(answer["error"].get<std::string>());
  Json value = std::move(answer["value"]);
  value["peak_memory_bytes"] = static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
  return value;
}

}  // namespace

Json run_in_child(const std::function<Json()>& work) { return finish(start(work)); }

std::array<Json, 2> run_side_by_side(const std::function<Json()>& work) {
  const Child first = start(work);
  const Child second = start(work);
  return {finish(first), finish(second)};
}

}  // namespace ccvt::bench
