// Runs the program itself on files of particles.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/particles.h"
#include "support/files.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

const std::string kLine = "sample --dim 3 --sites 60 --points-per-site 64 --periodic ";

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("particles: sample writes a load, analyze takes its box from it") {
  const TemporaryDirectory directory;
  CHECK(run(directory, kLine + "-q -o sites.npy").status == 0);
  const Ran ran = run(directory, kLine + "-o p.gadget --box-size 50 --repeat 2 --density 3");
  CHECK(ran.errors == "");
  CHECK(ran.status == 0);
  CHECK(ran.output.find("480 particles of mass 781.25 in a periodic box of 50\n") !=
        std::string::npos);
  const auto sites = read_points<float>(directory / "sites.npy");
  const auto particles = read_points<float>(directory / "p.gadget");
  REQUIRE(particles.cols() == 480);
  for (Eigen::Index s = 0; s < 60; ++s) {
    CHECK((particles.col(s) - 25 * sites.col(s)).cwiseAbs().maxCoeff() < 1e-5F);
  }
  // One thread or two, format 2, double.
  CHECK(run(directory, kLine + "-q -o a.gadget --gadget-format 2 --gas --threads 1").status == 0);
  CHECK(run(directory, kLine + "-q -o b.gadget --gadget-format 2 --gas --threads 2").status == 0);
  CHECK(get(directory / "a.gadget") == get(directory / "b.gadget"));
  CHECK(run(directory, kLine + "-q -o c.gadget --double").status == 0);
  CHECK(inspect_points(directory / "c.gadget").scalar == ScalarType::float64);

  const auto analyze = [&](const std::string& arguments) {
    CHECK(run(directory, "analyze -q -o out " + arguments).status == 0);
    return nlohmann::json::parse(get(directory / "out/metrics.json"));
  };
  CHECK(run(directory, kLine + "-q -o one.gadget --box-size 50").status == 0);
  auto of_sites = analyze("sites.npy --periodic");
  auto of_load = analyze("one.gadget");
  CHECK(of_load["periodic"] == true);
  CHECK(of_load["box"]["upper"] == std::vector<double>(3, 50));
  for (const char* const key : {"min_distance", "mean_distance", "spectral_peak"}) {
    CHECK(of_load[key].get<double>() == doctest::Approx(of_sites[key].get<double>()).epsilon(1e-4));
  }
  CHECK(analyze("one.gadget --box 0 0 0 60 60 60")["periodic"] == false);
  const auto tessellate = [&](const std::string& arguments) {
    return run(directory, "tessellate one.gadget --sites 7 -q -o cells.npy " + arguments);
  };
  CHECK(tessellate("--periodic").status == 0);
  const std::string of_own_box = get(directory / "cells.npy");
  CHECK(tessellate("--periodic --box 0 0 0 50 50 50").status == 0);
  CHECK(get(directory / "cells.npy") == of_own_box);
  CHECK(tessellate("--periodic-along 1,3").status == 0);
  CHECK(get(directory / "cells.npy") != of_own_box);
  CHECK(tessellate("--periodic --columns 1,2").errors.find("--periodic: needs --box") !=
        std::string::npos);
  CHECK(tessellate("--periodic --whiten").errors.find("--whiten: excludes periodic boxes") !=
        std::string::npos);
  const Ran other = run(directory, "analyze one.gadget a.gadget -o out");
  CHECK(other.status == 2);
  CHECK(other.errors.find("a.gadget: fills another box than one.gadget") != std::string::npos);
}

TEST_CASE("particles: a file that cannot grow is told, and nothing is left") {
  const TemporaryDirectory directory;
  std::vector<std::string> names = {"p.gadget"};
#ifdef CCVT_TEST_HDF5
  names.emplace_back("p.hdf5");
#endif
  for (const std::string& name : names) {
    CAPTURE(name);
    const Ran ran = run(directory, kLine + "-q --repeat 20 -o " + name, [] {
      const struct rlimit limit = {500000, 500000};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    });
    CHECK(ran.status == 1);
    CHECK(ran.errors == "ccvt: error: " + name + ": cannot be written: File too large\n");
    CHECK(directory.entries() == 0);
  }
}

TEST_CASE("particles: bad usage: one line, status 2, nothing written") {
  const TemporaryDirectory directory;
  struct Case {
    std::string line;
    std::vector<std::string> expected;
  };
  const Case cases[] = {
      {"sample --dim 2 --sites 9 --periodic -o p.gadget", {"p.gadget", "3 dimensions", "--dim 2"}},
      {"sample --dim 3 --sites 9 -o p.hdf5", {"p.hdf5", "--periodic is needed"}},
      {kLine + "-o p.npy --box-size 3", {"--box-size", ".gadget or .hdf5", "'.npy'"}},
      {kLine + "-o p.npy --gas", {"--gas", ".gadget or .hdf5"}},
      {kLine + "-o p.hdf5 --gadget-format 2", {"--gadget-format", "'.hdf5'"}},
      {kLine + "-o p.gadget --gadget-format 3", {"--gadget-format", "'3'"}},
      {kLine + "-o p.gadget --repeat 0", {"--repeat", "'0'"}},
      {kLine + "-o p.gadget --box-size -1", {"--box-size", "'-1'"}},
      {kLine + "-o p.gadget --density 0", {"--density", "above 0"}},
      {kLine + "-o p.gadget --repeat 200", {"p.gadget", "480000000 particles", ".hdf5 holds"}},
      {kLine + "-o s.npy --points-out p.gadget", {"p.gadget", "'.gadget'"}},
  };
  for (const Case& c : cases) {
    const Ran ran = run(directory, c.line);
    CAPTURE(c.line);
    CAPTURE(ran.errors);
    CHECK(ran.status == 2);
    CHECK(ran.output == "");
    CHECK(ran.errors.rfind("ccvt: error: ", 0) == 0);
    CHECK(ran.errors.find('\n') == ran.errors.size() - 1);
    for (const auto& part : c.expected) CHECK(ran.errors.find(part) != std::string::npos);
    CHECK(directory.entries() == 0);
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif  // CCVT_PROGRAM
