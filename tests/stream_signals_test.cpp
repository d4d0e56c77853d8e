// What becomes of standard streams when signals come, and when others are slow.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "support/files.h"
#include "support/pipe.h"
#include "support/process.h"
#include "support/room.h"
#include "support/wait_for.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

/// Writes more than a pipe of one page holds, and two files.
constexpr const char* kMuch =
    "sample --dim 2 --sites 20000 --points-per-site 1 --max-iterations 0 -q -o - --points-out "
    "p.npy --summary j.json";

/// Runs kMuch into a pipe that nobody reads before it is full and `when_full` has returned.
template <class WhenFull>
Ran send_slowly(const Room& room, int flags, const WhenFull& when_full) {
  Pipe pipe;
  REQUIRE(::fcntl(pipe.writing(), F_SETPIPE_SZ, 1) > 0);
  REQUIRE(::fcntl(pipe.writing(), F_SETFL, flags) == 0);
  Process process(CCVT_PROGRAM, words(kMuch), room.directory.path(), [&] {
    room.enter();
    ::dup2(pipe.writing(), STDOUT_FILENO);
  });
  CHECK(wait_for([&] {
    pollfd end = {pipe.writing(), POLLOUT, 0};
    return ::poll(&end, 1, 0) == 0 || !process.running();
  }));
  when_full(process);
  pipe.close_writing();
  const std::string sent = pipe.read();
  const int status = process.wait();
  return {status, sent, process.errors()};
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("a signal while standard input is read leaves nothing") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU}) {
    CAPTURE(signal);
    const Room room;
    Pipe pipe;
    Process process(CCVT_PROGRAM, words("tessellate - --sites 2 -o -"), room.directory.path(), [&] {
      room.enter();
      ::signal(signal, SIG_DFL);  // in the background some are ignored
      ::dup2(pipe.reading(), STDIN_FILENO);
    });
    pipe.close_reading();
    // It has begun to read, so that both stand-ins are there, when more is taken than fits.
    CHECK(pipe.write(std::string(2 * pipe.capacity(), '1')));
    CHECK(room.left() == 2);
    process.send(signal);
    CHECK(process.wait() == 128 + signal);
    CHECK(process.output().empty());
    CHECK(
        process.errors() ==
        (signal == SIGINT ? "ccvt: error: interrupted before there was anything to write\n" : ""));
    CHECK(room.left() == 0);
  }
}

TEST_CASE("signals that are ignored stay so, but for Ctrl-C") {
  for (const int signal : {SIGHUP, SIGQUIT, SIGXCPU}) {
    CAPTURE(signal);
    const Room room;
    Pipe pipe;
    Process process(CCVT_PROGRAM, words("tessellate - --sites 2 -q -o -"), room.directory.path(),
                    [&] {
                      room.enter();
                      ::signal(signal, SIG_IGN);
                      ::dup2(pipe.reading(), STDIN_FILENO);
                    });
    pipe.close_reading();
    CHECK(pipe.write(std::string(2 * pipe.capacity(), '\n')));
    process.send(signal);
    CHECK(pipe.write("0 0\n1 1\n"));
    pipe.close_writing();
    CHECK(process.wait() == 0);
    CHECK(!process.output().empty());
    CHECK(room.left() == 0);
  }
}

TEST_CASE("a signal in the moment when a stand-in appears leaves nothing") {
  const Room room;
  Process process(CCVT_PROGRAM, words("sample --dim 2 --sites 2 -o -"), room.directory.path(), [&] {
    room.enter();
    ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
  });
  // It is stopped when it has become the program, then before and after each system call.
  int status = 0;
  ::waitpid(process.id(), &status, 0);
  while (WIFSTOPPED(status) && room.left() == 0) {
    ::ptrace(PTRACE_SYSCALL, process.id(), nullptr, nullptr);
    ::waitpid(process.id(), &status, 0);
  }
  REQUIRE(room.left() == 1);
  process.send(SIGINT);
  ::ptrace(PTRACE_DETACH, process.id(), nullptr, nullptr);
  CHECK(process.wait() == 130);
  CHECK(process.errors() == "ccvt: error: interrupted before there was anything to write\n");
  CHECK(room.left() == 0);
}

TEST_CASE("standard output waits for who reads it") {
  const Room room;
  const Ran whole = run(room.directory, kMuch);
  REQUIRE(whole.status == 0);
  const auto check_whole = [&](const Ran& ran) {
    CHECK(ran.errors.empty());
    CHECK(ran.status == 0);
    CHECK(ran.output == whole.output);
    for (const char* const name : {"p.npy", "j.json"}) CHECK(fs::remove(room.directory / name));
    CHECK(room.left() == 0);
  };
  // Whoever shares a stream may have made it one that does not wait.
  check_whole(send_slowly(room, O_NONBLOCK, [](const Process&) {}));
  // The run is complete by then, and so is what it writes.
  check_whole(send_slowly(room, 0, [](const Process& process) { process.send(SIGINT); }));

  const Ran ended = send_slowly(room, 0, [](const Process& process) { process.send(SIGTERM); });
  CHECK(ended.status == 143);
  CHECK(!ended.output.empty());
  CHECK(ended.output.size() < whole.output.size());
  CHECK(whole.output.starts_with(ended.output));
  CHECK(room.left() == 0);
  CHECK(room.directory.entries() == 1);
}

TEST_CASE("standard input waits for who writes it") {
  const Room room;
  Pipe pipe;
  REQUIRE(::fcntl(pipe.reading(), F_SETFL, O_NONBLOCK) == 0);
  Process process(CCVT_PROGRAM, words("tessellate - --sites 2 -q -o s.csv"), room.directory.path(),
                  [&] {
                    room.enter();
                    ::dup2(pipe.reading(), STDIN_FILENO);
                  });
  pipe.close_reading();
  CHECK(pipe.write(std::string(2 * pipe.capacity(), '\n')));
  CHECK(pipe.write("0 0\n1 1\n"));
  pipe.close_writing();
  CHECK(process.wait() == 0);
  CHECK(process.errors().empty());
  CHECK(fs::exists(room.directory / "s.csv"));
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
