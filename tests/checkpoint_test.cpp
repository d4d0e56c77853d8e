// Solvers that are saved and loaded, and files that must not be.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/io.h"
#include "ccvt/lloyd.h"
#include "ccvt/problem.h"
#include "ccvt/publication.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/surface.h"
#include "ccvt/thin.h"
#include "ccvt/version.h"
#include "ccvt/weighted.h"
#include "checkpoint/checkpoint_file.h"
#include "random.h"
#include "support/files.h"
#include "support/generate.h"
#include "support/message.h"
#include "support/same.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Solver;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

using Event = ccvt::CheckpointRecord::Event;

template <class Scalar>
ccvt::Result<Scalar> result_of(const Solver<Scalar>& solver) {
  return {solver.sites(), solver.owners(), solver.summary()};
}

/// Runs a problem in one go, and once more in a new solver for each iteration, of another number of
/// threads each time. How many iterations there were.
template <class Scalar>
int check_each_step(const Problem<Scalar>& problem, Options options) {
  const TemporaryDirectory directory;
  options.threads = 1;
  const auto whole = ccvt::tessellate(problem, options);
  int solvers = 0;
  for (bool more = true; more; ++solvers) {
    options.threads = 1 + solvers % 3;
    Solver<Scalar> solver(problem, options);
    if (solvers > 0) solver.load(directory / "run");
    REQUIRE(solver.summary().iterations == solvers);
    more = solver.step();
    if (more) solver.save(directory / "run");
    if (!more) CHECK(differences(whole, result_of(solver)) == "");
  }
  CHECK(directory.entries() == (solvers > 1 ? 1 : 0));
  return solvers;
}

template <class Scalar>
int check_points(Layout layout, int dimension, Index points, Index sites, bool periodic,
                 const Options& options) {
  CAPTURE(dimension);
  CAPTURE(periodic);
  const Box box = uneven_box(dimension);
  const auto cloud = make_points<Scalar>(layout, box, points);
  Problem<Scalar> problem(cloud, sites);
  if (periodic) problem.set_domain(Domain::periodic(box));
  return check_each_step(problem, options);
}

/// A small problem, saved in its middle.
struct Saved {
  explicit Saved(const Options& options = {.threads = 1, .seed = 4}) {
    Solver<float> solver(problem, options);
    for (int k = 0; k < 3; ++k) REQUIRE(solver.step());
    solver.save(file);
    bytes = get(file);
  }
  [[nodiscard]] std::string loaded_message(const std::string& content) const {
    put(file, content);
    Solver<float> solver(problem, {.threads = 1, .seed = 4});
    return message_of([&] { solver.load(file); });
  }

  TemporaryDirectory directory;
  std::filesystem::path file = directory / "run";
  Points<float> points = make_points<float>(Layout::random, uneven_box(2), 900);
  Problem<float> problem{points, 20};
  std::string bytes;
};

}  // namespace

TEST_SUITE_BEGIN("checkpoint");

TEST_CASE_TEMPLATE("A run goes on after each iteration in a new solver", Scalar, float, double) {
  for (const bool periodic : {false, true}) {
    CHECK(check_points<Scalar>(Layout::random, 2, 8000, 150, periodic, {.seed = 1}) > 10);
    CHECK(check_points<Scalar>(Layout::random, 3, 6000, 90, periodic, {.seed = 2}) > 10);
  }
  check_points<Scalar>(Layout::clusters, 2, 5000, 200, false, {.seed = 3});
  check_points<Scalar>(Layout::duplicates, 3, 3000, 40, true, {.seed = 3});
  check_points<Scalar>(Layout::random, 1, 900, 12, true, {});
  check_points<Scalar>(Layout::random, 10, 3000, 60, false, {});
  // In the plane that is with 3,400 points and more.
  for (const bool periodic : {false, true}) {
    check_points<Scalar>(Layout::random, 2, 100'000, 16, periodic,
                         {.seed = 1, .descent_points = 0});
  }
}

TEST_CASE_TEMPLATE("Of whatever options", Scalar, float, double) {
  const auto check = [](const Options& options) {
    check_points<Scalar>(Layout::random, 2, 3000, 120, true, options);
  };
  Options cached{.seed = 5, .multilevel = false, .cached_passes = 3};
  check(cached);
  cached.tile_sites = 1;
  check(cached);
  check({.initialization = ccvt::Initialization::random, .multilevel = false});
  check({.initialization = ccvt::Initialization::coherent});
  check({.pairs = ccvt::PairSelection::all, .tile_sites = 3});
  check({.energy_tolerance = .01});
  check({.max_iterations = 12});
  check(Options::balzer2009());
  check(Options::fast_ccvt());
}

TEST_CASE_TEMPLATE("With cells that are large enough for patches", Scalar, float, double) {
  check_points<Scalar>(Layout::random, 2, 40'000, 20, false, {.seed = 1, .descent_points = 0});
  check_points<Scalar>(Layout::random, 3, 60'000, 12, true, {.seed = 1, .descent_points = 0});
}

TEST_CASE("What is loaded is saved again as it was, cell by cell") {
  const TemporaryDirectory directory;
  const auto points = make_points<float>(Layout::random, uneven_box(2), 100'000);
  const Problem<float> problem(points, 16);
  const Options options{.multilevel = false, .descent_points = 0};
  Solver<float> first(problem, options);
  for (int k = 0; k < 8; ++k) REQUIRE(first.step());
  first.save(directory / "first");
  CHECK(message_of([&] { first.save(""); }) ==
        "file: is empty, but must name the file to be written");
  Solver<float> second(problem, options);
  second.load(directory / "first");
  second.save(directory / "second");
  const auto cells = [](const std::string& bytes) {  // their length is at 24
    std::uint64_t length = 0;
    std::memcpy(&length, &bytes[24], sizeof length);
    return bytes.substr(bytes.size() - length);
  };
  CHECK(cells(get(directory / "first")) == cells(get(directory / "second")));
}

TEST_CASE_TEMPLATE("In the middle of a descent", Scalar, float, double) {
  for (const bool periodic : {false, true}) {
    for (const int least : {4, 20}) {
      const Options options{.seed = 2, .level_points = 4, .descent_points = least};
      check_points<Scalar>(Layout::random, 2, 12'000, 150, periodic, options);
      check_points<Scalar>(Layout::random, 3, 12'000, 150, periodic, options);
      Options samples = options;
      samples.until = ccvt::Until::blue_noise;
      check_points<Scalar>(Layout::random, 2, 12'000, 150, periodic, samples);
    }
  }
}

TEST_CASE("With capacities, sites that stay, sites that are given, and owners") {
  const Box box = uneven_box(2);
  const std::vector<Index> capacities = unequal_capacities(40);
  const auto points = make_points<double>(Layout::random, box, sum_of(capacities));
  Problem<double> problem(points, 40);
  problem.set_capacities(capacities);
  check_each_step(problem, {});
  problem.set_domain(Domain::periodic(box, {true, false}));
  problem.set_fixed_sites(points.leftCols(7));
  check_each_step(problem, {.seed = 3});
  problem.set_initial_sites(points.rightCols(40));
  check_each_step(problem, {.seed = 3});
  const auto end = ccvt::tessellate(problem, {.max_iterations = 2});
  problem.set_initial_owners(end.owners);
  check_each_step(problem, {});
}

TEST_CASE("What has been recorded is kept") {
  const Saved saved;
  Solver<float> first(saved.problem, {.threads = 1, .seed = 4});
  Solver<float> second(saved.problem, {.threads = 1, .seed = 4});
  first.load(saved.file);
  second.load(saved.file);
  CHECK(first.summary().iterations == 3);
  REQUIRE(first.summary().iterations_log.size() == 3);
  CHECK(first.summary().iterations_log[2].energy == first.summary().energy);
  CHECK(first.summary().seconds_total == second.summary().seconds_total);
  const double before = first.summary().seconds_total;
  CHECK(before > 0);
  first.run();
  CHECK(first.summary().seconds_total > before);
  CHECK(first.summary().iterations_log.front().iteration == 1);
}

TEST_CASE("Also in a solver that has gone elsewhere, and while files are held back") {
  const Saved saved;
  Solver<float> other(saved.problem, {.threads = 2, .seed = 4});
  for (int k = 0; k < 8; ++k) REQUIRE(other.step());
  const ccvt::Publication never_published;
  other.load(saved.file);
  other.save(saved.directory / "again");
  CHECK(other.summary().iterations == 3);
  Solver<float> third(saved.problem, {.seed = 4});
  third.load(saved.directory / "again");
  third.run();
  other.run();
  CHECK(differences(result_of(third), result_of(other)) == "");
}

TEST_CASE("A file that is cut off or has another bit anywhere is refused") {
  const Saved saved;
  for (std::size_t size = 1; size < saved.bytes.size(); size += 1 + size / 500) {
    CAPTURE(size);
    const std::string message = saved.loaded_message(saved.bytes.substr(0, size));
    CHECK(message.find(size < 40 ? "is not a checkpoint of ccvt, or not all of one"
                                 : "bytes, but was written with") != std::string::npos);
  }
  CHECK(saved.loaded_message(saved.bytes + "x").find("was written with") != std::string::npos);
  ccvt::Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const std::size_t at = k < 100 ? static_cast<std::size_t>(k) : random.below(saved.bytes.size());
    std::string damaged = saved.bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random.below(8)));
    CAPTURE(at);
    CHECK(saved.loaded_message(damaged) != "nothing thrown");
  }
  CHECK(saved.loaded_message(saved.bytes) == "nothing thrown");
}

TEST_CASE("What is refused leaves the solver as it was") {
  const Saved saved;
  Solver<float> solver(saved.problem, {.seed = 4});
  for (int k = 0; k < 6; ++k) REQUIRE(solver.step());
  std::string damaged = saved.bytes;
  damaged[damaged.size() - 20] ^= 1;  // of the last cells
  put(saved.file, damaged);
  CHECK(message_of([&] { solver.load(saved.file); }) ==
        saved.file.string() + ": is damaged: what it has of cells is not as written");
  solver.run();
  CHECK(differences(result_of(solver), ccvt::tessellate(saved.problem, {.seed = 4})) == "");
}

TEST_CASE("What is damaged is named, and what another format or machine wrote") {
  const Saved saved;
  const auto changed = [&](std::size_t at) {
    std::string bytes = saved.bytes;
    bytes[at] ^= 1;
    const std::string message = saved.loaded_message(bytes);
    return message.substr(saved.file.string().size() + 2);
  };
  CHECK(changed(0) == "is not a checkpoint of ccvt, or not all of one");
  CHECK(changed(8) == "was written by a machine of another byte order");
  CHECK(changed(12) == "has the format 6 of checkpoints, and only 7 can be continued");
  CHECK(changed(16) == "is damaged: its header is not as written");
  CHECK(changed(100) == "is damaged: what it has of the sites is not as written");
  CHECK(message_of([&] {
          Solver<float> solver(saved.problem);
          solver.load(saved.directory / "none");
        }).find("none") != std::string::npos);
}

TEST_CASE("Another problem or other options are refused, and the message says which") {
  const Saved saved;
  const auto refusal = [&](const auto& problem, const Options& options) {
    Solver solver(problem, options);
    const std::string message = message_of([&] { solver.load(saved.file); });
    const std::string start = saved.file.string() + ": is of another run: ";
    REQUIRE(message.substr(0, start.size()) == start);
    return message.substr(start.size());
  };
  const Options same{.seed = 4};
  CHECK(refusal(saved.problem, {.seed = 5}) == "the option seed is 4 there, and here 5");
  CHECK(refusal(saved.problem, {.seed = 4, .cached_passes = 1}) ==
        "the option cached_passes is 0 there, and here 1");
  CHECK(refusal(saved.problem, {.seed = 4, .tile_sites = 8}) ==
        "the option tile_sites is 64 there, and here 8");
  CHECK(refusal(Problem<float>(saved.points, 21), same) ==
        "the number of sites is 20 there, and here 21");
  const Points<float> fewer = saved.points.leftCols(899);
  CHECK(refusal(Problem<float>(fewer, 20), same) ==
        "the number of points is 900 there, and here 899");
  const Points<double> wider = saved.points.cast<double>();
  CHECK(refusal(Problem<double>(wider, 20), same) ==
        "the type of coordinates is float there, and here double");
  Points<float> moved = saved.points;
  moved(1, 451) = std::nextafter(moved(1, 451), 0.F);
  CHECK(refusal(Problem<float>(moved, 20), same) == "the points are not the same");
  Points<float> exchanged = saved.points;
  exchanged.col(3).swap(exchanged.col(700));
  CHECK(refusal(Problem<float>(exchanged, 20), same) == "the points are not the same");
  std::vector<Index> capacities = saved.problem.capacities();
  ++capacities[2];
  --capacities[3];
  CHECK(refusal(Problem<float>(saved.points, 20).set_capacities(capacities), same) ==
        "the capacities are not the same");
  CHECK(refusal(Problem<float>(saved.points, 20).set_domain(Domain::periodic(uneven_box(2))),
                same) == "the bounds of the domain are not the same");
  CHECK(refusal(Problem<float>(saved.points, 20).set_initial_sites(fewer.leftCols(20)), same) ==
        "the initial sites are not the same");
  CHECK(refusal(Problem<float>(saved.points, 20).set_fixed_sites(fewer.leftCols(2)), same) ==
        "the fixed sites are not the same");
  const auto owners = ccvt::tessellate(saved.problem, {.max_iterations = 0}).owners;
  CHECK(refusal(Problem<float>(saved.points, 20).set_initial_owners(owners),
                {.seed = 4, .multilevel = true}) == "the option multilevel is 1 there, and here 0");
}

TEST_CASE("Another version's file is refused, and one that is whole but holds something else") {
  const Saved saved;
  constexpr std::size_t kHeader = 40;  // with the length of the first part at 16
  std::uint64_t length = 0;
  std::memcpy(&length, &saved.bytes[16], sizeof length);
  // The file with its first part changed, and digests that fit.
  const auto made = [&](const auto& change) {
    std::string common = saved.bytes.substr(kHeader, length);
    const std::string tiles = saved.bytes.substr(kHeader + length + sizeof length);
    change(common);
    ccvt::CheckpointWriter writer(saved.file, std::as_bytes(std::span(common)), tiles.size());
    writer.write(std::as_bytes(std::span(tiles)));
    writer.commit();
    const std::string message = saved.loaded_message(get(saved.file));
    const std::string start = saved.file.string() + ": ";
    return message.substr(0, start.size()) == start ? message.substr(start.size()) : message;
  };
  const std::string version = CCVT_VERSION;
  CHECK(made([&](std::string& common) { common.replace(8, version.size(), "0.0.0"); }) ==
        "was written by version 0.0.0, and this is " + version + ": only the same can continue it");
  const std::string other = "is damaged: it does not hold what it should";
  CHECK(made([](std::string& common) { common.clear(); }) == other);
  CHECK(made([](std::string& common) { common.pop_back(); }) == other);
  CHECK(made([](std::string& common) { common += "x"; }) == other);
  CHECK(made([](std::string& common) { common[0] = 127; }) == other);
  CHECK(made([](std::string&) {}) == "nothing thrown");
}

TEST_CASE("What has ended is neither saved nor goes on") {
  const Saved saved;
  Solver<float> solver(saved.problem, {.seed = 4});
  solver.run();
  CHECK(message_of([&] { solver.save(saved.file); }) ==
        saved.file.string() + ": a run that has ended leaves no checkpoint");
  CHECK(message_of([&] { solver.load(saved.file); }) ==
        saved.file.string() + ": a run that has ended does not go on from a checkpoint");
  Solver<float> fresh(saved.problem, {.seed = 4});
  CHECK(message_of([&] { fresh.save(saved.directory / "no" / "run"); }) ==
        "IoError: " + (saved.directory / "no" / "run").string() +
            ": cannot be written: there is no directory '" + (saved.directory / "no").string() +
            "'");
}

TEST_CASE("A run that is kept goes on from its file, and tells of it") {
  const Saved saved;
  const auto whole = ccvt::tessellate(saved.problem, {.seed = 4});
  std::vector<Event> events;
  std::vector<int> iterations;
  Options options{.seed = 4};
  options.checkpoint = saved.directory / "kept";
  options.checkpoint_seconds = 0;
  options.on_checkpoint = [&](const ccvt::CheckpointRecord& record) {
    CHECK(record.failure.empty());
    CHECK(record.seconds > 0);
    events.push_back(record.event);
    iterations.push_back(record.iteration);
  };
  {
    Solver<float> first(saved.problem, options);
    CHECK(first.step());
    CHECK(first.step());
  }
  CHECK(events == std::vector<Event>{Event::saved, Event::saved, Event::saved});
  CHECK(iterations == std::vector<int>{0, 1, 2});
  events.clear();
  iterations.clear();
  options.checkpoint_seconds = 1e9;
  const auto second = ccvt::tessellate(saved.problem, options);
  CHECK(differences(whole, second) == "");
  CHECK(events == std::vector<Event>{Event::continued});
  CHECK(iterations == std::vector<int>{2});
  CHECK(std::filesystem::exists(options.checkpoint));
}

TEST_CASE("However a run that is kept is cut short, it goes on to the same end") {
  const Saved saved;
  const auto whole = ccvt::tessellate(saved.problem, {.seed = 4});
  for (int way = 0; way < 4; ++way) {
    CAPTURE(way);
    for (int stop = 1; stop < whole.summary.iterations; ++stop) {
      CAPTURE(stop);
      Options options{.seed = 4};
      options.checkpoint = saved.directory / "kept";
      std::filesystem::remove(options.checkpoint);
      Options limited = options;
      int iterations = 0;
      if (way == 0) limited.max_iterations = stop;
      limited.on_iteration = [&](const ccvt::IterationRecord&) {
        ++iterations;
        return way != 1 || iterations < stop;
      };
      if (way == 2) limited.cancelled = [&] { return iterations >= stop; };
      Solver<float> first(saved.problem, limited);
      if (way < 3) {
        first.run();
      } else {
        while (iterations < stop) first.step();
        first.cancel();
      }
      CHECK(first.summary().termination ==
            (way == 0 ? Termination::iteration_limit : Termination::cancelled));
      CHECK(first.summary().iterations == stop);
      Solver<float> second(saved.problem, options);
      CHECK(second.summary().iterations == stop);
      second.run();
      CHECK(differences(whole, result_of(second)) == "");
    }
  }
}

TEST_CASE("What is kept is taken up even where the time is over before") {
  const TemporaryDirectory directory;
  const auto points = make_points<float>(Layout::random, uneven_box(2), 200'000);
  const Problem<float> problem(points, 1000);
  Options options{.seed = 4};
  options.checkpoint = directory / "kept";
  options.max_iterations = 12;
  const auto kept = ccvt::tessellate(problem, options);
  options.cancelled = [] { return true; };
  Solver<float> again(problem, options);
  CHECK(again.summary().iterations == 12);
  again.run();
  CHECK(again.summary().iterations >= 12);
  CHECK(again.summary().energy <= kept.summary.energy);
}

TEST_CASE("A checkpoint that fails later does not end a run, and is told of once") {
  const Saved saved;
  const std::filesystem::path folder = saved.directory / "folder";
  std::filesystem::create_directory(folder);
  Options options{.seed = 4};
  options.checkpoint = folder / "kept";
  options.checkpoint_seconds = 0;
  options.on_iteration = [&](const ccvt::IterationRecord& record) {
    if (record.iteration == 2) std::filesystem::remove_all(folder);
    return true;
  };
  const auto result = ccvt::tessellate(saved.problem, options);
  CHECK(differences(result, ccvt::tessellate(saved.problem, {.seed = 4})) == "");
  REQUIRE(result.summary.warnings.size() == 1);
  CHECK(result.summary.warnings[0] ==
        "after iteration 2 no checkpoint could be written: " + options.checkpoint.string() +
            ": cannot be written: there is no directory '" + folder.string() + "'");
  CHECK(message_of([&] { ccvt::tessellate(saved.problem, options); }) ==
        "IoError: " +
            result.summary.warnings[0].substr(
                std::string("after iteration 2 no checkpoint could be written: ").size()));
}

TEST_CASE("Functions that keep no checkpoint refuse to") {
  const Saved saved;
  Options options;
  options.checkpoint = saved.file;
  const std::string start = "Options::checkpoint is " + saved.file.string() + ": ";
  CHECK(message_of([&] { ccvt::lloyd(saved.problem, options); }) == start + "lloyd() keeps none");
  CHECK(message_of([&] { ccvt::thin(saved.points, 5, {.tessellation = options}); }) ==
        start + "thin() keeps none");
  ccvt::SurfaceOptions surface;
  surface.tessellation = options;
  CHECK(message_of([&] { surface.validate(); }) == start + "sample_surface() keeps none");
  options.checkpoint_seconds = -1;
  CHECK(message_of([&] { options.validate(); }) ==
        "Options::checkpoint_seconds is -1: it must be 0 (after each iteration) or more seconds");
}

TEST_CASE("The way to unit points is kept") {
  const Saved saved;
  std::vector<double> masses;
  for (int p = 0; p < 900; ++p) masses.push_back(1 + p % 5);
  ccvt::MassOptions options;
  const auto whole = ccvt::tessellate_masses(saved.points, masses, 20, options);
  options.relaxation.checkpoint = saved.directory / "kept";
  options.relaxation.max_iterations = 4;
  CHECK(ccvt::tessellate_masses(saved.points, masses, 20, options).summary.iterations == 4);
  options.relaxation.max_iterations = 1000;
  const auto end = ccvt::tessellate_masses(saved.points, masses, 20, options);
  CHECK(same_bits(end.sites.eigen(), whole.sites.eigen()));
  CHECK(end.owners == whole.owners);
  CHECK(end.summary.iterations == whole.summary.iterations);
}

TEST_SUITE_END();
