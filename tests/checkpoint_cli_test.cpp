// Runs of the program that are kept, and go on. Those that are killed: see checkpoint/kills.py.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "support/catch_in_time.h"
#include "support/files.h"
#include "support/process.h"
#include "support/wait_for.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

const std::string kLine = "sample --dim 2 --sites 2000 --points-per-site 512 --threads 1 -o s.npy ";
const std::string kGoesOn = "ccvt: the same command, or one with other limits, goes on from run\n";

/// The result of a run that nothing ends, and how long that takes.
struct Whole {
  explicit Whole(const TemporaryDirectory& directory) {
    const auto start = Clock::now();
    REQUIRE(run(directory, kLine).status == 0);
    seconds = Clock::now() - start;
    sites = get(directory / "s.npy");
    fs::remove(directory / "s.npy");
  }
  std::chrono::duration<double> seconds{};
  std::string sites;
};

/// Goes on without a limit, to the same end as the whole run.
void check_goes_on(const TemporaryDirectory& directory, const Whole& whole) {
  const Ran ran = run(directory, kLine + "--checkpoint run");
  CAPTURE(ran.errors);
  CHECK(ran.status == 0);
  CHECK(ran.errors.rfind("ccvt: goes on from run, after iteration ", 0) == 0);
  CHECK(get(directory / "s.npy") == whole.sites);
  CHECK(fs::is_empty(directory / "run"));
}

/// As `ulimit -f` has it.
void limit_files(rlim_t bytes) {
  const rlimit limit{bytes, bytes};
  ::setrlimit(RLIMIT_FSIZE, &limit);
}

}  // namespace

TEST_SUITE_BEGIN("checkpoint");

TEST_CASE("A run that a time limit ends leaves its result, and goes on when it is run again") {
  const TemporaryDirectory directory;
  const Whole whole(directory);
  Ran ran{};
  REQUIRE(catch_in_time(whole.seconds / 2, [&](const auto& delay) {
    fs::remove_all(directory / "run");
    ran = run(directory, kLine + "--checkpoint run --time-limit " + std::to_string(delay.count()));
    if (ran.status == 1) return Caught::too_early;
    REQUIRE(ran.status == 0);
    if (fs::is_empty(directory / "run")) return Caught::too_late;
    // An end before the first iteration has nothing to tell.
    return ran.errors == kGoesOn ? Caught::in_time : Caught::too_early;
  }));
  CHECK(ran.output.rfind("time_limit after ", 0) == 0);
  CHECK(get(directory / "s.npy") != whole.sites);
  check_goes_on(directory, whole);
}

TEST_CASE("One that ends before anything can be kept says so") {
  const TemporaryDirectory directory;
  const Ran ran = run(directory, kLine + "--checkpoint run --time-limit 1e-6");
  CHECK(ran.status == 0);
  CHECK(ran.errors.find("ccvt: run: nothing is kept there: the same command begins anew\n") !=
        std::string::npos);
  CHECK(fs::is_empty(directory / "run"));
}

TEST_CASE("A run that Ctrl-C ends goes on too") {
  const TemporaryDirectory directory;
  const Whole whole(directory);
  REQUIRE(catch_in_time(whole.seconds / 2, [&](const auto& delay) {
    fs::remove_all(directory / "run");
    Process process(CCVT_PROGRAM, words(kLine + "--checkpoint run"), directory.path());
    std::this_thread::sleep_for(delay);
    process.send(SIGINT);
    const int status = process.wait();
    if (status == 0) return Caught::too_late;
    return status == 130 && process.errors() == kGoesOn ? Caught::in_time : Caught::too_early;
  }));
  check_goes_on(directory, whole);
}

TEST_CASE("And one that a number of iterations ends, which says nothing when it is to be quiet") {
  const TemporaryDirectory directory;
  const Whole whole(directory);
  const Ran first = run(directory, kLine + "--checkpoint run --max-iterations 7 -q");
  CHECK(first.status == 0);
  CHECK(first.errors.empty());
  const Ran second = run(directory, kLine + "--checkpoint run --max-iterations 9");
  CHECK(second.errors == "ccvt: goes on from run, after iteration 7\n" + kGoesOn);
  check_goes_on(directory, whole);
}

TEST_CASE("Another command than that which was kept is refused, and what is kept stays") {
  const TemporaryDirectory directory;
  const Whole whole(directory);
  REQUIRE(run(directory, kLine + "--checkpoint run --max-iterations 7").status == 0);
  const std::string kept = get(directory / "run" / "ccvt.checkpoint");
  fs::remove(directory / "s.npy");
  const auto refusal = [&](const std::string& more) {
    const Ran ran = run(directory, kLine + "--checkpoint run " + more);
    CHECK(ran.status == 2);
    CHECK(!fs::exists(directory / "s.npy"));
    return ran.errors;
  };
  const std::string start = "ccvt: error: run/ccvt.checkpoint: ";
  CHECK(refusal("--seed 3") ==
        start + "is of another run: the option seed is 0 there, and here 3\n");
  CHECK(refusal("--until stable") ==
        start + "is of another run: the option until is blue_noise there, and here stable\n");
  CHECK(refusal("--distribution white") ==
        start + "is of another run: the points are not the same\n");
  CHECK(get(directory / "run" / "ccvt.checkpoint") == kept);
  put(directory / "run" / "ccvt.checkpoint", kept.substr(0, 5000));
  CHECK(refusal("") ==
        start + "has 5000 bytes, but was written with " + std::to_string(kept.size()) + "\n");
  put(directory / "run" / "ccvt.checkpoint", "no");
  CHECK(refusal("") == start + "is not a checkpoint of ccvt, or not all of one\n");
}

TEST_CASE("A directory is one process's at a time") {
  const TemporaryDirectory directory;
  Process first(CCVT_PROGRAM,
                words("sample --dim 2 --sites 40000 --points-per-site 1000 --threads 1 -o s.npy "
                      "--checkpoint run"),
                directory.path());
  REQUIRE(wait_for([&] { return fs::exists(directory / "run" / "ccvt.checkpoint"); }));
  const Ran second = run(directory, kLine + "--checkpoint run");
  CHECK(first.running());
  first.send(SIGKILL);
  first.wait();
  CHECK(second.status == 2);
  CHECK(second.errors == "ccvt: error: --checkpoint: run: another process keeps its run there\n");
}

TEST_CASE("What a killed process has left of a checkpoint is removed, and nothing else") {
  const TemporaryDirectory directory;
  fs::create_directory(directory / "run");
  put(directory / "run" / ".ccvt-0123456789abcdef.part", "ccvtckpt and more");
  put(directory / "run" / ".ccvt-1123456789abcdef.part", "something else");
  put(directory / "run" / ".ccvt-2123456789abcdef.part", "");  // before anything was written
  REQUIRE(run(directory, kLine + "--checkpoint run").status == 0);
  CHECK(!fs::exists(directory / "run" / ".ccvt-0123456789abcdef.part"));
  CHECK(fs::exists(directory / "run" / ".ccvt-1123456789abcdef.part"));
  CHECK(!fs::exists(directory / "run" / ".ccvt-2123456789abcdef.part"));
}

TEST_CASE("A first checkpoint that cannot be written ends the run, a later one does not") {
  const TemporaryDirectory directory;
  const Whole whole(directory);
  const Ran early = run(directory, kLine + "--checkpoint run", [] { limit_files(1000); });
  CHECK(early.status == 1);
  CHECK(early.errors == "ccvt: error: run/ccvt.checkpoint: cannot be written: File too large\n");
  CHECK(fs::is_empty(directory / "run"));
  // The first level has a share of the points.
  const Ran late = run(directory, kLine + "--checkpoint run --checkpoint-every 0",
                       [] { limit_files(2'000'000); });
  CHECK(late.status == 0);
  CHECK(late.errors ==
        "ccvt: warning: run/ccvt.checkpoint: cannot be written: File too large: the run goes on, "
        "and what was kept of it before stays\n");
  CHECK(get(directory / "s.npy") == whole.sites);
  CHECK(fs::is_empty(directory / "run"));
}

TEST_CASE("A directory for checkpoints that cannot be is refused before anything is computed") {
  const TemporaryDirectory directory;
  put(directory / "file", "x");
  const auto refusal = [&](const std::string& more) {
    const Ran ran = run(directory, kLine + more);
    CHECK(ran.status == 2);
    CHECK(directory.entries() == 1);
    return ran.errors;
  };
  CHECK(refusal("--checkpoint no/run") ==
        "ccvt: error: --checkpoint: no/run: cannot be made: No such file or directory\n");
  CHECK(refusal("--checkpoint file").rfind("ccvt: error: --checkpoint: file: ", 0) == 0);
  CHECK(refusal("--checkpoint-every 5") ==
        "ccvt: error: --checkpoint-every requires --checkpoint; see ccvt sample --help\n");
  CHECK(run(directory, "quantize x.npy --codewords 4 -o c.npy --checkpoint run").status == 2);
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
