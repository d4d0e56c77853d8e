// Runs the program itself.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/files.h"
#include "support/png.h"
#include "support/process.h"

using namespace std::string_literals;

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

nlohmann::json json_of(const fs::path& path) { return nlohmann::json::parse(get(path)); }

std::map<std::string, std::string> contents(const TemporaryDirectory& directory) {
  std::map<std::string, std::string> result;
  for (const auto& entry : fs::directory_iterator(directory.path())) {
    result[entry.path().filename().string()] =
        entry.is_regular_file() ? get(entry.path()) : std::string();
  }
  return result;
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("sample: files, summary and the same bytes for any number of threads") {
  const TemporaryDirectory directory;
  const Ran ran = run(directory,
                      "sample --dim 3 --sites 40 --points-per-site 32 --periodic --seed 7 "
                      "-o sites.npy --points-out points.npy --owners-out owners.npy "
                      "--summary summary.json --threads 2");
  CHECK(ran.status == 0);
  CHECK(ran.errors == "");
  CHECK(std::count(ran.output.begin(), ran.output.end(), '\n') == 1);
  CHECK(directory.entries() == 4);
  CHECK(inspect_points(directory / "sites.npy").scalar == ScalarType::float32);

  const auto sites = read_points<float>(directory / "sites.npy");
  const auto points = read_points<float>(directory / "points.npy");
  const auto owners = read_indices(directory / "owners.npy");
  CHECK(sites.rows() == 3);
  REQUIRE(sites.cols() == 40);
  REQUIRE(points.cols() == 40 * 32);
  REQUIRE(owners.size() == 40 * 32);
  CHECK((points.array() >= 0).all());
  CHECK((points.array() < 1).all());
  CHECK(capacity_error(owners, 40) == 0);

  double energy = 0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Eigen::Array3f d =
        (points.col(p) - sites.col(owners[static_cast<std::size_t>(p)])).array().abs();
    energy += static_cast<double>(d.min(1 - d).square().sum());
  }
  const auto json = json_of(directory / "summary.json");
  CHECK(json["version"].is_string());
  CHECK(json["command"] == "sample");
  CHECK(json["dimension"] == 3);
  CHECK(json["points"] == 1280);
  CHECK(json["sites"] == 40);
  CHECK(json["seed"] == 7);
  CHECK(json["threads"] == 2);
  CHECK(json["termination"] == "stable");
  CHECK(json["iterations"].get<int>() > 0);
  CHECK(json["energy"].get<double>() == doctest::Approx(energy).epsilon(1e-4));
  CHECK(json["normalized_energy"].get<double>() ==
        doctest::Approx(energy * std::pow(40, 2.0 / 3) / 1280).epsilon(1e-4));
  CHECK(json["capacity_error"] == 0.0);
  const auto& seconds = json["seconds"];
  CHECK(seconds["total"].get<double>() > 0);
  CHECK(seconds["initialization"].get<double>() + seconds["relaxation"].get<double>() <=
        seconds["total"].get<double>() * 1.0001);
  double in_phases = 0;
  for (const auto& [name, phase] : json["phases"].items()) {
    in_phases += phase["seconds"].get<double>();
    CHECK(phase["work_seconds"].get<double>() >= 0);
  }
  CHECK(json["phases"]["swap"]["tasks"].get<int>() > 0);
  CHECK(in_phases == doctest::Approx(seconds["total"].get<double>()).epsilon(0.5));
  CHECK(json["peak_memory_bytes"].get<std::uint64_t>() > 1000000);

  // The library does the same.
  Problem<float> problem(points, 40);
  problem.set_domain(Domain::periodic(Box::unit(3)));
  CHECK(tessellate(problem, {.threads = 1, .seed = 7}).sites == sites);
  const auto before = contents(directory);
  CHECK(run(directory,
            "sample --dim 3 --sites 40 --points-per-site 32 --periodic --seed 7 "
            "-o sites.npy --points-out points.npy --owners-out owners.npy --threads 1")
            .status == 0);
  CHECK(contents(directory) == before);
}

TEST_CASE("sample: distributions and scalar types") {
  const TemporaryDirectory directory;
  std::map<std::string, std::string> points;
  for (const char* const name : {"white", "jittered", "square", "hexagonal"}) {
    const Ran ran = run(directory,
                        "sample --dim 2 --sites 16 --points-per-site 16 --quiet "
                        "-o s.csv --points-out p.csv --distribution "s +
                            name);
    CHECK(ran.status == 0);
    CHECK(ran.output + ran.errors == "");
    points[get(directory / "p.csv")] = name;
  }
  CHECK(points.size() == 4);
  CHECK(run(directory, "sample --dim 2 --sites 16 --points-per-site 16 -o s.csv --points-out p.csv")
            .status == 0);
  CHECK(points[get(directory / "p.csv")] == "jittered");
  CHECK(run(directory, "sample --dim 2 --sites 4 --double -o s.npy").status == 0);
  CHECK(inspect_points(directory / "s.npy").scalar == ScalarType::float64);
  CHECK(run(directory, "sample --dim 2 --sites 4 --max-iterations 1 -o s.npy --summary s.json")
            .status == 0);
  CHECK(json_of(directory / "s.json")["termination"] == "iteration_limit");
  CHECK(
      run(directory, "sample --dim 2 --sites 400 --energy-tolerance 0.5 -o s.npy --summary s.json")
          .status == 0);
  CHECK(json_of(directory / "s.json")["termination"] == "energy_tolerance");
  const std::string fine =
      "sample --dim 2 --sites 32 --points-per-site 2048 -o s.npy --summary s.json";
  for (const auto& [end, termination] : {std::pair{"", "blue_noise"},
                                         {" --until blue-noise", "blue_noise"},
                                         {" --until stable", "stable"},
                                         {" --preset default", "stable"},
                                         {" --time-limit 1e-9", "time_limit"}}) {
    const std::string arguments = fine + end;
    CAPTURE(arguments);
    CHECK(run(directory, arguments).status == 0);
    CHECK(json_of(directory / "s.json")["termination"] == termination);
  }
  CHECK(run(directory, "sample --dim 2 --sites 16 --preset fast-ccvt -o s.npy --summary s.json")
            .status == 0);
  CHECK(json_of(directory / "s.json")["initialization"] == "coherent");
}

TEST_CASE("tessellate: formats, capacities, initial sites, box") {
  const TemporaryDirectory directory;
  const auto points = sample_uniform<double>(Box::unit(2), 900, 3, Distribution::white);
  write_points(directory / "p.npy", points);
  write_points(directory / "p.csv", points);
  write_points(directory / "start.txt", points.leftCols(3));
  put(directory / "capacities.csv", "capacity\n100\n300\n500\n");
  const auto before = contents(directory);

  CHECK(run(directory, "tessellate p.npy --sites 30 -o a.npy --owners-out a.csv").status == 0);
  CHECK(run(directory, "tessellate p.csv --sites 30 -o b.npy --owners-out b.csv").status == 0);
  CHECK(get(directory / "a.npy") == get(directory / "b.npy"));
  CHECK(get(directory / "a.csv") == get(directory / "b.csv"));
  CHECK(inspect_points(directory / "a.npy").scalar == ScalarType::float64);
  CHECK(run(directory, "tessellate p.npy --sites 30 --float -o c.npy").status == 0);
  CHECK(inspect_points(directory / "c.npy").scalar == ScalarType::float32);

  CHECK(run(directory,
            "tessellate p.npy --initial-sites start.txt --capacities capacities.csv "
            "-o d.csv --owners-out d.npy --summary d.json")
            .status == 0);
  const auto owners = read_indices(directory / "d.npy");
  const auto sites = read_points<double>(directory / "d.csv");
  REQUIRE(sites.cols() == 3);
  for (Index site = 0; site < 3; ++site) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Index size = 0;
    for (std::size_t p = 0; p < owners.size(); ++p) {
      if (owners[p] != site) continue;
      sum += points.col(static_cast<Eigen::Index>(p));
      ++size;
    }
    CHECK(size == 100 + 200 * site);
    CHECK((sum / size - sites.col(site)).norm() < 1e-12);
  }
  CHECK(json_of(directory / "d.json")["command"] == "tessellate");
  // Capacities say how many sites there are.
  const std::string given = "tessellate p.npy --capacities capacities.csv -o ";
  CHECK(run(directory, given + "d1.csv").status == 0);
  CHECK(run(directory, given + "d2.csv --sites 3").status == 0);
  CHECK(get(directory / "d1.csv") == get(directory / "d2.csv"));

  // The numbers after --box end where the next word is no number.
  for (const char* const line : {"tessellate p.npy --sites 30 --periodic --box 0 0 1 1 -o e.npy",
                                 "tessellate --sites 30 --periodic --box 0 0 1 1 p.npy -o e.npy",
                                 "tessellate --sites 30 --periodic --box=0 0 1 1 p.npy -o e.npy",
                                 "tessellate --sites 30 --periodic --box 0,0,1,1 p.npy -o e.npy",
                                 "tessellate -o e.npy --sites 30 --periodic p.npy --box 0 0 1 1"}) {
    fs::remove(directory / "e.npy");
    CHECK(run(directory, line).status == 0);
    Problem<double> problem(points, 30);
    problem.set_domain(Domain::periodic(Box::unit(2)));
    CHECK(read_points<double>(directory / "e.npy") == tessellate(problem).sites);
  }
  CHECK(run(directory, "tessellate p.npy --sites 9 --box -.5 -1e0 1.5 1 -o e.npy").status == 0);
  for (const auto& [name, bytes] : before) CHECK(get(directory / name) == bytes);
}

TEST_CASE("stipple: every output") {
  const TemporaryDirectory directory;
  std::vector<unsigned> samples(40 * 30);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<unsigned>(i % 40 * 6);
  put(directory / "picture.png", make_png(40, 30, 8, 0, samples));
  for (const char* const name : {"o.svg", "o.png", "o.csv", "o.npy", "o.txt"}) {
    const Ran ran = run(directory,
                        "stipple picture.png --sites 200 --points-per-site 16 "
                        "--summary s.json -o "s +
                            name);
    CAPTURE(name);
    CHECK(ran.errors == "");
    CHECK(ran.status == 0);
    CHECK(json_of(directory / "s.json")["command"] == "stipple");
    CHECK(json_of(directory / "s.json")["points"] == 3200);
  }
  const auto dots = read_points<float>(directory / "o.npy");
  CHECK(dots.cols() == 200);
  CHECK(dots == read_points<float>(directory / "o.csv"));
  CHECK((dots.row(0).array() < 20).count() > 120);  // the left half is darker
  const Image drawn = read_image(directory / "o.png");
  CHECK(drawn.width >= 40);
  CHECK(run(directory,
            "stipple picture.png --sites 200 --points-per-site 16 --invert --gamma 2 "
            "-o i.csv")
            .status == 0);
  CHECK((read_points<float>(directory / "i.csv").row(0).array() > 20).count() > 120);
  CHECK(run(directory,
            "stipple picture.png --sites 20 --points-per-site 16 --dot-radius 1.25 "
            "-o r.svg")
            .status == 0);
  CHECK(get(directory / "r.svg").find("r=\"1.25\"") != std::string::npos);
  const Ran pale = run(
      directory, "stipple picture.png --sites 20 --points-per-site 16 --dot-radius 1e-9 -o w.png");
  CHECK(pale.status == 0);
  CHECK(pale.errors.find("ccvt: warning: w.png is white: its pixels") != std::string::npos);
}

TEST_CASE("help and version") {
  const TemporaryDirectory directory;
  for (const char* const line : {"--help", "sample --help", "tessellate -h", "stipple --help"}) {
    const Ran ran = run(directory, line);
    CHECK(ran.status == 0);
    CHECK(ran.output.find("Example") != std::string::npos);
    CHECK(ran.errors == "");
  }
  const Ran ran = run(directory, "--version");
  CHECK(ran.status == 0);
  CHECK(ran.output.rfind("ccvt ", 0) == 0);
}

TEST_CASE("bad input: one line, status 2, nothing written") {
  const TemporaryDirectory directory;
  put(directory / "p.csv", "0,0\n1,0\n0,1\n1,1\n");
  put(directory / "nan.csv", "0,0\nnan,0\n");
  put(directory / "empty.csv", "");
  put(directory / "short.csv", "1\n2\n");
  put(directory / "sum.csv", "1\n2\n");
  put(directory / "zero.csv", "0\n4\n");
  put(directory / "three.csv", "0,0,0\n");
  put(directory / "far.csv", "1e145,0\n0,1\n2,2\n");
  put(directory / "huge.npy",
      "\x93NUMPY\x01\x00\x46\x00{'descr': '<f4', 'fortran_order': False, "
      "'shape': (1000000000, 900)}          \n"s);
  put(directory / "new\nline.csv", "1,x\n");
  put(directory / "white.png", make_png(2, 2, 8, 0, {255, 255, 255, 255}));
  put(directory / "clear.png", make_png(1, 1, 8, 4, {0, 0}));
  put(directory / "cut.png", make_png(2, 2, 8, 0, {0, 255, 0, 255}).substr(0, 60));
  fs::create_directory(directory / "folder");
  fs::create_directory(directory / "folder.npy");
  const std::string sample = "sample --dim 2 --sites 8 --points-per-site 4 -o o.npy ";
  const std::string tessellate = "tessellate p.csv --sites 2 -o o.npy ";
  struct Case {
    std::string line;
    Arguments expected;
  };
  const Case cases[] = {
      {"", {"needs a command", "tessellate", "see ccvt --help"}},
      {"tesselate p.csv", {"unknown command 'tesselate'", "tessellate", "See ccvt --help"}},
      {"--tesselate p.csv", {"unknown argument '--tesselate'", "see ccvt --help"}},
      {"draw", {"'draw'"}},
      {"sample --dim 2 -o o.npy", {"sample: needs --sites; see ccvt sample --help"}},
      {"sample --sites 8 -o o.npy", {"sample: needs --dim"}},
      {"sample --dim 2 --sites 8", {"sample: needs --output"}},
      {"sample --dim 2 --sites 8 -o", {"--output: needs a value"}},
      {"sample --dim 2 --dim 2 --sites 8 -o o.npy", {"--dim: is given more than once"}},
      {"sample --dim 0 --sites 8 -o o.npy", {"--dim", "'0'", "at least 1"}},
      {"sample --dim 2 --sites 0 -o o.npy", {"--sites", "'0'", "at least 1"}},
      {"sample --dim 2 --sites -3 -o o.npy", {"--sites", "'-3'"}},
      {"sample --dim 2 --sites 1e3 -o o.npy", {"--sites", "'1e3'", "whole number"}},
      {"sample --dim 2 --sites 99999999999999999999 -o o.npy", {"--sites"}},
      {sample + "--points-per-site 0", {"--points-per-site"}},
      {"sample --dim 2 --sites 8 --points-per-site 0 -o o.npy", {"--points-per-site", "'0'"}},
      {"sample --dim 2 --sites 2000000000 -o o.npy", {"512000000000 points", "memory"}},
      {"sample --dim 2000000000 --sites 8000000 -o o.npy", {"would need about", "EiB of memory"}},
      {"sample --dim 100000 --sites 1000000 -o o.npy", {"would need about", "TiB", "machine has"}},
      {sample + "--seed -1", {"--seed", "'-1'"}},
      {sample + "--seed 18446744073709551616", {"--seed"}},
      {sample + "--threads x", {"--threads", "'x'"}},
      {sample + "--max-iterations -1", {"--max-iterations"}},
      {sample + "--preset fast", {"--preset", "'fast'", "fast-ccvt"}},
      {sample + "--energy-tolerance 1", {"--energy-tolerance", "'1'", "below 1"}},
      {sample + "--energy-tolerance nan", {"--energy-tolerance", "'nan'"}},
      {sample + "--time-limit 0", {"--time-limit", "'0'", "above 0"}},
      {sample + "--until blue", {"--until", "'blue'", "stable or blue-noise"}},
      {sample + "--distribution blue", {"--distribution", "'blue'", "jittered"}},
      {sample + "--float --double", {"--float: cannot be given beside --double"}},
      {sample + "--float=maybe", {"--float: takes no value"}},
      {sample + "--periodic=false", {"--periodic: takes no value"}},
      {sample + "--quiet=3", {"--quiet: takes no value"}},
      {sample + "--frobnicate", {"'--frobnicate'"}},
      {sample + "surplus", {"'surplus'"}},
      {sample + "--points-out o.npy", {"o.npy", "--output", "--points-out", "differ"}},
      {sample + "--summary ./folder/../o.npy", {"--output", "--summary", "differ"}},
      {sample + "--owners-out o.png", {"o.png", "'.png'", ".npy, .csv or .txt"}},
      {sample + "--owners-out none/o.npy", {"none/o.npy", "no directory 'none'"}},
      {sample + "--summary json:-", {"--summary", "'json:-'"}},
      {sample + "--summary folder", {"folder", "is a directory"}},
      {sample + "--summary /dev/full", {"/dev/full", "regular"}},
      {sample + "--summary /proc/o.json", {"/proc/o.json", "cannot be written"}},
      {sample + "--summary p.csv/o.json", {"p.csv/o.json", "no directory"}},
      {"sample --dim 2 --sites 8 -o folder.npy", {"folder.npy", "is a directory"}},
      {"sample --dim 2 --sites 8 -o sites",
       {"sites", "extension", ".npy, .csv, .txt, .gadget or .hdf5"}},
      {"quantize p.csv --codewords 2 --gap 1 -o o.npy", {"--gap", "'1'", "below 1"}},
      {"quantize p.csv --codewords 2 --method lloyd --effort 3 -o o.npy", {"--effort", "lloyd"}},
      {"quantize p.csv --codewords 2 --effort -1 -o o.npy", {"--effort", "'-1'"}},
      {"quantize p.csv --codewords 2 --method lloyd --train-sample 3 -o o.npy",
       {"--train-sample", "exact"}},
      {"quantize p.csv --codewords 2 --method lloyd --gap 0.1 -o o.npy", {"--gap", "exact"}},
      {"tessellate p.csv -o o.npy", {"--sites", "--initial-sites"}},
      {"tessellate --sites 2 -o o.npy", {"POINTS"}},
      {"tessellate p.csv --sites 5 -o o.npy", {"p.csv", "5", "4"}},
      {"tessellate p.csv --sites 2 -o p.csv", {"p.csv", "--output", "POINTS", "differ"}},
      {"tessellate none.csv --sites 2 -o o.npy", {"none.csv", "no such file"}},
      {"tessellate empty.csv --sites 2 -o o.npy", {"empty.csv", "is empty"}},
      {"tessellate nan.csv --sites 2 -o o.npy", {"nan.csv", "line 2", "'nan'", "finite"}},
      {"tessellate huge.npy --sites 2 -o o.npy", {"huge.npy", "truncated"}},
      {"tessellate white.png --sites 2 -o o.npy", {"white.png", "extension"}},
      {"tessellate p.csv --initial-sites three.csv -o o.npy", {"three.csv"}},
      {"tessellate p.csv --initial-sites p.csv --sites 2 -o o.npy", {"--initial-sites"}},
      {"quantize far.csv --codewords 2 --capacities sum.csv -o o.npy",
       {"error: far.csv: points: coordinate 0 of points[0]"}},
      {"quantize p.csv --codewords 2 --capacities sum.csv -o o.npy", {"error: sum.csv", "3", "4"}},
      {tessellate + "--capacities sum.csv", {"sum.csv", "3", "4"}},
      {tessellate + "--capacities zero.csv", {"zero.csv", "0"}},
      {tessellate + "--capacities three.csv", {"three.csv", "line 1"}},
      {tessellate + "--periodic", {"--periodic", "--box"}},
      {tessellate + "--box 0 0 1", {"--box", "3 numbers", "4 are needed"}},
      {tessellate + "--box 0 0 1 0", {"--box", "dimension 2"}},
      {tessellate + "--box 0 0 1 inf", {"--box", "'inf'"}},
      {tessellate + "--box nan 0 1 1", {"--box", "'nan'"}},
      {"tessellate p.csv --sites 3 --box -o e.csv", {"--box", "'-o'"}},
      {tessellate + "--box 0 0 .5 1", {"p.csv", "box"}},
      {"stipple white.png --sites 2 -o o.svg", {"white.png", "white everywhere"}},
      {"stipple clear.png --sites 2 -o o.svg", {"clear.png", "white everywhere"}},
      {"stipple cut.png --sites 2 -o o.svg", {"cut.png", "truncated"}},
      {"stipple p.csv --sites 2 -o o.svg", {"p.csv", "neither PNG nor JPEG"}},
      {"stipple none.png --sites 2 -o o.svg", {"none.png", "no such file"}},
      {"stipple white.png --sites 2 -o o.jpg", {"o.jpg", ".svg, .png, .csv, .txt or .npy"}},
      {"stipple white.png --sites 2 -o o.svg --gamma -1", {"--gamma", "'-1'"}},
      {"stipple white.png --sites 2 -o o.svg --dot-radius 0", {"--dot-radius", "above 0"}},
      {"stipple white.png --sites 2 -o o.npy --dot-radius 1", {"--dot-radius", "not into .npy"}},
      {"quantize p.csv --codewords 3 --train-sample 2 -o o.npy",
       {"--train-sample: 2 vectors", "3"}},
  };
  const auto before = contents(directory);
  for (const Case& c : cases) {
    const Ran ran = run(directory, c.line);
    CAPTURE(c.line);
    CAPTURE(ran.errors);
    CHECK(ran.status == 2);
    CHECK(ran.output == "");
    CHECK(ran.errors.rfind("ccvt: error: ", 0) == 0);
    CHECK(ran.errors.find('\n') == ran.errors.size() - 1);
    CHECK(ran.errors.size() < 400);
    for (const auto& part : c.expected) {
      CAPTURE(part);
      CHECK(ran.errors.find(part) != std::string::npos);
    }
    CHECK(contents(directory) == before);
  }
  const Ran odd = run(directory, {"tessellate", "new\nline.csv", "--sites", "1", "-o", "o.npy"});
  CHECK(odd.status == 2);
  CHECK(odd.errors.find('\n') == odd.errors.size() - 1);
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif  // CCVT_PROGRAM
