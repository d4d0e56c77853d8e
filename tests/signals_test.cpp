// How the program ends when it is told to.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "support/catch_in_time.h"
#include "support/files.h"
#include "support/process.h"
#include "support/wait_for.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr const char* kNothingYet = "ccvt: error: interrupted before there was anything to write\n";

/// Interrupts runs, from half of the time that a whole one takes on, until one is caught.
Ran interrupted_half_way(const TemporaryDirectory& directory, const std::string& line,
                         int status_of_whole) {
  const auto start = Clock::now();
  const Ran whole = run(directory, line);
  CAPTURE(whole.errors);
  REQUIRE(whole.status == status_of_whole);
  Ran ran{};
  REQUIRE(catch_in_time((Clock::now() - start) / 2.0, [&](const auto& delay) {
    Process process(CCVT_PROGRAM, words(line), directory.path());
    std::this_thread::sleep_for(delay);
    process.send(SIGINT);
    ran = {process.wait(), process.output(), process.errors()};
    if (ran.status == status_of_whole) return Caught::too_late;
    // Before the program has set up how it ends, SIGINT ends it.
    return ran.status == 1000 + SIGINT ? Caught::too_early : Caught::in_time;
  }));
  return ran;
}

/// Whether a file is being written, and has begun to grow.
bool is_writing(const TemporaryDirectory& directory) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory.path())) {
    if (entry.path().filename().string().rfind(".ccvt-", 0) != 0) continue;
    if (fs::file_size(entry.path(), error) > 0 && !error) return true;
  }
  return false;
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("Ctrl-C writes the tessellation reached so far") {
  const TemporaryDirectory directory;
  const std::string line =
      "sample --dim 2 --sites 4000 --points-per-site 1024 --threads 1 -o s.npy --points-out p.npy "
      "--owners-out o.npy --summary s.json";
  const auto started = Clock::now();
  REQUIRE(run(directory, line).status == 0);
  REQUIRE(catch_in_time((Clock::now() - started) / 2.0, [&](const auto& delay) {
    for (const char* const name : {"s.npy", "p.npy", "o.npy", "s.json"}) {
      fs::remove(directory / name);
    }
    Process process(CCVT_PROGRAM, words(line), directory.path());
    std::this_thread::sleep_for(delay);
    process.send(SIGINT);
    const int status = process.wait();
    if (status == 0) return Caught::too_late;
    if (status == 1000 + SIGINT) return Caught::too_early;
    CHECK(status == 130);
    if (directory.entries() == 0) {
      CHECK(process.errors() == kNothingYet);
      return Caught::too_early;
    }
    CHECK(directory.entries() == 4);
    const auto summary = nlohmann::json::parse(get(directory / "s.json"));
    if (summary["termination"] != "cancelled") return Caught::too_late;  // it was writing
    // That points had not joined, or nothing.
    const auto& warnings = summary["warnings"];
    CHECK(process.errors() ==
          (warnings.empty() ? "" : "ccvt: warning: " + warnings[0].get<std::string>() + "\n"));
    const auto owners = read_indices(directory / "o.npy");
    CHECK(owners.size() == 4000 * 1024);
    CHECK(capacity_error(owners, 4000) == 0);
    CHECK(read_points<float>(directory / "s.npy").cols() == 4000);
    return Caught::in_time;
  }));
}

TEST_CASE("Ctrl-C while a file is read ends the program at once") {
  const TemporaryDirectory directory;
  // Who reads on finds the mistake at the end.
  std::string text;
  for (int i = 0; i < 1'500'000; ++i) text += "0.123456789,0.987654321\n";
  put(directory / "p.csv", text + "x,1\n");
  for (const char* const line :
       {"tessellate p.csv --sites 4 -o s.csv", "encode p.csv --codebook p.csv -o s.csv",
        "quantize p.csv --codewords 4 -o s.csv", "analyze p.csv -o out"}) {
    CAPTURE(line);
    const Ran ran = interrupted_half_way(directory, line, 2);
    CHECK(ran.status == 130);
    CHECK(ran.errors == kNothingYet);
    CHECK(directory.entries() == 1);
  }
}

TEST_CASE("Ctrl-C while analyze draws its pictures ends it at once, and leaves nothing") {
  const TemporaryDirectory directory;
  // In four dimensions the picture of the spectrum takes longest.
  write_points(directory / "p.npy", sample_uniform<double>(Box::unit(4), 3000, 1));
  REQUIRE(catch_in_time(std::chrono::milliseconds(500), [&](const auto& delay) {
    fs::remove_all(directory / "out");
    Process process(CCVT_PROGRAM, words("analyze p.npy -q --threads 1 -o out"), directory.path());
    REQUIRE(wait_for([&] { return fs::exists(directory / "out") || !process.running(); }));
    std::this_thread::sleep_for(delay);
    process.send(SIGINT);
    const int status = process.wait();
    if (status == 0) return Caught::too_late;
    CHECK(status == 130);
    CHECK(process.errors() == kNothingYet);
    CHECK(directory.entries() == 1);
    return Caught::in_time;
  }));
}

TEST_CASE("a second Ctrl-C, or a termination, leaves no partial file") {
  const TemporaryDirectory directory;
  // Points as text take a while to write: long enough to be caught at it.
  const std::string line =
      "sample --dim 64 --sites 2 --points-per-site 60000 --max-iterations 0 -o s.npy "
      "--points-out p.txt";
  for (const bool twice : {true, false}) {
    for (int attempt = 0;; ++attempt) {
      REQUIRE(attempt < 20);
      Process process(CCVT_PROGRAM, words(line), directory.path());
      REQUIRE(wait_for([&] { return is_writing(directory) || !process.running(); }));
      process.send(twice ? SIGINT : SIGTERM);
      if (twice) {
        // Signals less than 0.3 s apart count as one key press. A fast machine would have written
        // the file by then: the program is stopped meanwhile, once it has heard the first.
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        process.send(SIGSTOP);
        std::this_thread::sleep_for(std::chrono::milliseconds(350));
        process.send(SIGINT);
        process.send(SIGCONT);
      }
      const int status = process.wait();
      if (fs::exists(directory / "p.txt")) {  // it was complete before
        for (const auto& entry : fs::directory_iterator(directory.path())) fs::remove(entry);
        continue;
      }
      CHECK(status == (twice ? 130 : 143));
      CHECK(process.errors() ==
            (twice ? "ccvt: error: interrupted again: what had been reached is discarded\n" : ""));
      CHECK(directory.entries() == 0);
      break;
    }
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif  // CCVT_PROGRAM
