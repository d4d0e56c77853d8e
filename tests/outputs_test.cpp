// What the program writes: never over its inputs, never in part, never unnoticed.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "support/files.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader =
    "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\ndata file: ";

void check_one_line(const Ran& ran, int status, const std::string& part) {
  CAPTURE(ran.errors);
  CHECK(ran.status == status);
  CHECK(ran.errors.rfind("ccvt: error: ", 0) == 0);
  CHECK(ran.errors.find('\n') == ran.errors.size() - 1);
  CHECK(ran.errors.find(part) != std::string::npos);
}

std::size_t unfinished_in(const TemporaryDirectory& directory) {
  std::size_t count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(directory.path())) {
    count += entry.path().filename().string().rfind(".ccvt-", 0) == 0 ? 1 : 0;
  }
  return count;
}

/// What the killed run leaves of its four outputs, in the order in which they appear.
enum class State { old_file, new_file, damaged };

struct Outputs {
  explicit Outputs(const TemporaryDirectory& directory) : points(get(directory / "p.csv")) {
    owners = get(directory / "o.csv");
    summary = get(directory / "j.json");
    sites = get(directory / "s.csv");
  }
  void put_into(const TemporaryDirectory& directory) const {
    put(directory / "p.csv", points);
    put(directory / "o.csv", owners);
    put(directory / "j.json", summary);
    put(directory / "s.csv", sites);
  }
  std::string points, owners, summary, sites;
};

State state(const std::string& now, const std::string& before, const std::string& after) {
  return now == before ? State::old_file : now == after ? State::new_file : State::damaged;
}

/// A summary holds times, which no two runs share: told by the seed.
State state_of_summary(const std::string& now, const std::string& before) {
  if (now == before) return State::old_file;
  const auto json = nlohmann::json::parse(now, nullptr, false);
  const bool whole = !json.is_discarded() && json.contains("peak_memory_bytes");
  return whole && json["seed"] == 2 ? State::new_file : State::damaged;
}

std::array<State, 4> states(const Outputs& now, const Outputs& before, const Outputs& after) {
  return {state(now.points, before.points, after.points),
          state(now.owners, before.owners, after.owners),
          state_of_summary(now.summary, before.summary),
          state(now.sites, before.sites, after.sites)};
}

/// Ends runs at random times; returns how many left some new beside some old files.
int count_mixed(int signal, int rounds) {
  const TemporaryDirectory directory;
  const std::string line =
      "sample --dim 2 --sites 100 --points-per-site 400 --max-iterations 0 --threads 1 -q -o s.csv "
      "--points-out p.csv --owners-out o.csv --summary j.json --seed ";
  REQUIRE(run(directory, line + "1").status == 0);
  const Outputs before(directory);
  const auto start = std::chrono::steady_clock::now();
  REQUIRE(run(directory, line + "2").status == 0);
  const auto whole = std::chrono::steady_clock::now() - start;
  const Outputs after(directory);
  int mixed = 0;
  std::mt19937 random(7);
  for (int round = 0; round < rounds; ++round) {
    before.put_into(directory);
    Process process(CCVT_PROGRAM, words(line + "2"), directory.path());
    std::this_thread::sleep_for(whole * std::uniform_int_distribution<int>(200, 1200)(random) /
                                1000);
    process.send(signal);
    process.wait();
    const auto found = states(Outputs(directory), before, after);
    CHECK(std::count(found.begin(), found.end(), State::damaged) == 0);
    const auto changed = std::count(found.begin(), found.end(), State::new_file);
    CHECK(std::count(found.begin(), found.begin() + changed, State::new_file) == changed);
    mixed += changed > 0 && changed < 4 ? 1 : 0;
    if (signal != SIGKILL) CHECK(unfinished_in(directory) == 0);
    for (const auto& entry : fs::directory_iterator(directory.path())) fs::remove(entry);
  }
  return mixed;
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("no output replaces an input, whatever name or link leads to it") {
  const TemporaryDirectory directory;
  std::string bytes(512, '\1');
  bytes[0] = '\2';
  put(directory / "data.raw", bytes);
  put(directory / "mask.raw", bytes);
  put(directory / "v.nhdr", std::string(kHeader) + "data.raw\n");
  put(directory / "m.nhdr", std::string(kHeader) + "mask.raw\n");
  put(directory / "p.csv", "0,0\n1,0\n0,1\n1,1\n");
  fs::create_symlink("p.csv", directory / "link.csv");
  fs::create_hard_link(directory / "p.csv", directory / "hard.csv");
  fs::create_symlink("data.raw", directory / "link.ply");
  fs::create_symlink("new.csv", directory / "one.csv");
  fs::create_symlink("new.csv", directory / "other.csv");
  const std::size_t entries = directory.entries();
  const std::string volume = "volume v.nhdr --mask m.nhdr --sites 5 --points-per-site 8 -q ";
  const std::string tessellate = "tessellate p.csv --sites 2 ";
  const struct {
    std::string line;
    std::string part;
  } cases[] = {
      {volume + "-o s.ply --summary data.raw", "the data file of FILE name the same file"},
      {volume + "-o s.ply --summary mask.raw", "the data file of --mask name the same file"},
      {volume + "-o link.ply", "--output and the data file of FILE name the same file"},
      {tessellate + "-o link.csv", "--output and POINTS name the same file"},
      {tessellate + "-o hard.csv", "--output and POINTS name the same file"},
      {tessellate + "-o one.csv --owners-out other.csv", "--output and --owners-out"},
      {tessellate + "-o one.csv --summary new.csv", "--output and --summary"},
  };
  for (const auto& c : cases) {
    CAPTURE(c.line);
    check_one_line(run(directory, c.line), 2, c.part);
    CHECK(directory.entries() == entries);
  }
  CHECK(get(directory / "data.raw") == bytes);
  CHECK(get(directory / "mask.raw") == bytes);
  CHECK(run(directory, volume + "-o s.ply").status == 0);

  fs::create_directory(directory / "report");
  fs::create_symlink("../p.csv", directory / "report/points.svg");
  check_one_line(run(directory, "analyze p.csv -o report"), 2, "would be written over");
  CHECK(get(directory / "p.csv") == "0,0\n1,0\n0,1\n1,1\n");
}

TEST_CASE("no output replaces what standard output goes to") {
  const TemporaryDirectory directory;
  const std::string said = (directory / "said.txt").string();
  const Ran ran = run(directory, "sample --dim 2 --sites 4 -o s.csv --summary said.txt", [&] {
    ::dup2(::open(said.c_str(), O_WRONLY | O_CREAT, 0666), STDOUT_FILENO);
  });
  check_one_line(ran, 2, "--summary names the file that standard output goes to");
}

TEST_CASE("a link as output: what it leads to is replaced, and the link stays") {
  const TemporaryDirectory directory;
  fs::create_directory(directory / "results");
  put(directory / "results/s.csv", "old");
  fs::create_symlink("results/s.csv", directory / "s.csv");
  CHECK(run(directory, "sample --dim 2 --sites 4 -q -o s.csv").status == 0);
  CHECK(fs::is_symlink(directory / "s.csv"));
  CHECK(read_points<float>(directory / "results/s.csv").cols() == 4);
}

TEST_CASE("a file that grows too large: one line, status 1, nothing left") {
  const TemporaryDirectory directory;
  put(directory / "s.csv", "old");
  const Ran ran = run(directory, "sample --dim 2 --sites 400 -q -o s.csv --points-out p.csv", [] {
    const struct rlimit small = {100'000, 100'000};
    ::setrlimit(RLIMIT_FSIZE, &small);
  });
  check_one_line(ran, 1, "p.csv: cannot be written: File too large");
  CHECK(get(directory / "s.csv") == "old");
  CHECK(directory.entries() == 1);
}

TEST_CASE("an output that is a directory is said to be one") {
  const TemporaryDirectory directory;
  put(directory / "p.csv", "1,2\n3,4\n5,6\n");
  fs::create_directory(directory / "report");
  check_one_line(run(directory, "tessellate p.csv --sites 2 -o report"), 2,
                 "report: is a directory; must be a file with the extension .npy, .csv or .txt");
}

TEST_CASE("standard output that is closed or full: one line, status 1; outputs are whole") {
  const TemporaryDirectory directory;
  const auto closed = [] { ::close(STDOUT_FILENO); };
  const auto full = [] { ::dup2(::open("/dev/full", O_WRONLY), STDOUT_FILENO); };
  const auto unread = [] {
    int ends[2];
    if (::pipe(ends) != 0) ::_exit(125);
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]);
  };
  for (const char* const line : {"--help", "sample --help", "--version"}) {
    CAPTURE(line);
    check_one_line(run(directory, line, closed), 1, "standard output: cannot be written");
    check_one_line(run(directory, line, full), 1, "No space left on device");
    check_one_line(run(directory, line, unread), 1, "Broken pipe");
  }
  const std::string line = "sample --dim 2 --sites 4 -o s.csv";
  const std::function<void()> ways[] = {closed, full, unread};
  for (const auto& before : ways) {
    check_one_line(run(directory, line, before), 1, "standard output: cannot be written");
    CHECK(directory.entries() == 1);
    CHECK(read_points<float>(directory / "s.csv").cols() == 4);
    fs::remove(directory / "s.csv");
  }
  CHECK(run(directory, line + " -q", closed).status == 0);

  // Nor does what is printed go into a file that got the number of a stream.
  put(directory / "data.raw", std::string(511, '\1') + '\2');
  put(directory / "v.nhdr", std::string(kHeader) + "data.raw\n");
  const std::string volume = "volume v.nhdr --sites 5 --points-per-site 8 -o v.csv";
  check_one_line(run(directory, volume, closed), 1, "standard output: cannot be written");
  CHECK(run(directory, line + " --sites", [] { ::close(STDERR_FILENO); }).status == 2);
}

TEST_CASE("analyze: a directory that others make at the same moment is used") {
  const TemporaryDirectory directory;
  write_points(directory / "p.csv", sample_uniform<double>(Box::unit(2), 9, 1));
  for (int round = 0; round < 6; ++round) {
    std::vector<std::unique_ptr<Process>> processes;
    for (int i = 0; i < 6; ++i) {
      processes.push_back(std::make_unique<Process>(
          CCVT_PROGRAM, words("analyze p.csv -q --threads 1 -o out"), directory.path()));
    }
    for (const auto& process : processes) {
      const int status = process->wait();
      CAPTURE(process->errors());
      CHECK(status == 0);
    }
    CHECK(unfinished_in(directory) == 0);
    CHECK(fs::exists(directory / "out/report.html"));
    fs::remove_all(directory / "out");
  }
}

TEST_CASE("analyze: what fails leaves no directory, and what was there as it was") {
  const TemporaryDirectory directory;
  write_points(directory / "p.csv", sample_uniform<double>(Box::unit(2), 500, 1));
  const auto limited = [] {
    const struct rlimit small = {4000, 4000};
    ::setrlimit(RLIMIT_FSIZE, &small);
  };
  check_one_line(run(directory, "analyze p.csv -q -o out", limited), 1, "File too large");
  CHECK(directory.entries() == 1);
  CHECK(run(directory, "analyze p.csv -q -o out").status == 0);
  const std::string before = get(directory / "out/metrics.json");
  write_points(directory / "p.csv", sample_uniform<double>(Box::unit(2), 500, 2));
  check_one_line(run(directory, "analyze p.csv -q -o out", limited), 1, "File too large");
  CHECK(get(directory / "out/metrics.json") == before);
  CHECK(unfinished_in(directory) == 0);
}

TEST_CASE("a killed run leaves all outputs old or all new, unless between two renames") {
  CHECK(count_mixed(SIGKILL, 60) <= 2);
}

TEST_CASE("a terminated run leaves all outputs old or all new, and nothing else") {
  CHECK(count_mixed(SIGTERM, 40) == 0);
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif  // CCVT_PROGRAM
