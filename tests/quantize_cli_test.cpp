// ccvt quantize, run as a program.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/files.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

nlohmann::json json_of(const std::filesystem::path& path) {
  return nlohmann::json::parse(get(path));
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("quantize ends within the gap that is allowed") {
  const test::TemporaryDirectory directory;
  REQUIRE(run(directory, "sample --dim 3 --sites 1500 --seed 4 --points-per-site 1 -q -o v.npy")
              .status == 0);
  const auto gap_of = [&](const std::string& option) {
    const Ran ran = run(directory, "quantize v.npy --codewords 20 -q " + option +
                                       " -o c.npy --codes-out o.npy --summary s.json");
    REQUIRE(ran.status == 0);
    const auto summary = json_of(directory / "s.json");
    CHECK(summary["smallest_cell"] == 75);
    CHECK(summary["largest_cell"] == 75);
    return summary["gap"].get<double>();
  };
  CHECK(gap_of("") < 1e-12);
  const double gap = gap_of("--gap 0.01");
  CHECK(gap > 1e-6);
  CHECK(gap <= 0.01);
}

TEST_CASE("quantize ends when its time is over") {
  const TemporaryDirectory directory;
  REQUIRE(run(directory, "sample --dim 3 --sites 1500 --seed 4 --points-per-site 1 -q -o v.npy")
              .status == 0);
  for (const std::string method : {"exact", "pairwise", "lloyd"}) {
    CAPTURE(method);
    const Ran ran = run(directory, "quantize v.npy --codewords 20 --time-limit 1e-9 --method " +
                                       method + " -o c.npy --codes-out o.npy --summary s.json");
    CHECK(ran.status == 0);
    CHECK(ran.output.find("time_limit") != std::string::npos);
    const auto summary = json_of(directory / "s.json");
    CHECK(summary["termination"] == "time_limit");
    if (method != "lloyd") CHECK(summary["smallest_cell"] == 75);
  }
}

TEST_CASE("quantize --effort breeds codebooks") {
  const TemporaryDirectory directory;
  REQUIRE(run(directory, "sample --dim 2 --sites 900 --seed 4 --points-per-site 1 -q -o v.npy")
              .status == 0);
  const auto energy_of = [&](const std::string& option) {
    const Ran ran = run(directory, "quantize v.npy --codewords 12 --threads 1 -q " + option +
                                       " -o c.npy --summary s.json");
    REQUIRE(ran.status == 0);
    return json_of(directory / "s.json")["energy"].get<double>();
  };
  const double none = energy_of("--effort 0");
  CHECK(energy_of("--effort 200") < none);
  const Ran given =
      run(directory, "quantize v.npy --codewords 12 --seeding c.npy --effort 2 -o d.npy");
  CHECK(given.status == 2);
  CHECK(given.errors.find("--effort") != std::string::npos);
  CHECK(energy_of("--restarts 1") == energy_of("--restarts 1 --effort 0"));
}

TEST_CASE("the peak of memory is the program's own, not that of what started it") {
  const TemporaryDirectory directory;
  REQUIRE(run(directory, "sample --dim 2 --sites 100 --points-per-site 1 -q -o v.npy").status == 0);
  std::vector<char> large(std::size_t{400} << 20, 1);
  CHECK(std::count(large.begin(), large.end(), 1) == std::ssize(large));  // all of it is touched
  REQUIRE(run(directory, "quantize v.npy --codewords 4 --summary s.json -o c.npy").status == 0);
  CHECK(json_of(directory / "s.json")["peak_memory_bytes"].get<double>() < 3e8);
}

TEST_CASE("quantize says beforehand when it may take much memory, and no less than it does") {
  const TemporaryDirectory directory;
  REQUIRE(run(directory, "sample --dim 2 --sites 4300 --points-per-site 1 -q -o v.npy").status ==
          0);
  const std::string command =
      "quantize v.npy --codewords 4200 --seeding random --max-iterations 0 --summary s.json -o "
      "c.npy";
  const Ran ran = run(directory, command);
  CHECK(ran.status == 0);
  CHECK(ran.errors == "ccvt: v.npy: training takes up to about 1.3 GiB of memory\n");
  CHECK(json_of(directory / "s.json")["peak_memory_bytes"].get<double>() < 1.4e9);
  CHECK(run(directory, command + " -q").errors.empty());
  CHECK(run(directory,
            "quantize v.npy --codewords 4000 --method lloyd --seeding random "
            "--max-iterations 0 -o c.npy")
            .errors.empty());
  // Codewords from a file are not drawn, and nothing is bred from them.
  for (const std::string option : {"--restarts 2", "--effort 2"}) {
    const Ran drawn =
        run(directory, "quantize v.npy --codewords 2 --seeding v.npy " + option + " -o c.npy");
    CHECK(drawn.status == 2);
    CHECK(drawn.errors.find(option.substr(0, option.find(' ')) + ": codewords from a file") !=
          std::string::npos);
  }
  // What is refused for another reason is not refused for its memory.
  const Ran refused = run(directory, "quantize v.npy --codewords 2000000000 -o c.npy");
  CHECK(refused.status == 2);
  CHECK(refused.errors.find("memory") == std::string::npos);
  CHECK(refused.errors.find("2000000000") != std::string::npos);
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
