// What ccvt-bench makes of its measurements.
#ifdef CCVT_BENCH_TESTS

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "paper/experiments.h"
#include "paper/report_parts.h"
#include "support/files.h"
#include "support/generate.h"
#include "support/inverted_lists.h"
#include "support/plot.h"
#include "support/statistics.h"

namespace ccvt::bench {
TEST_SUITE_BEGIN("bench");

TEST_CASE("the growth exponent of a power law is its exponent") {
  for (const double exponent : {-1.0, 0.0, 0.97, 1.0, 2.5}) {
    std::vector<double> x;
    std::vector<double> y;
    for (double v = 1000; v < 1e7; v *= 3.7) {
      x.push_back(v);
      y.push_back(4e-6 * std::pow(v, exponent));
    }
    CHECK(growth_exponent(x, y) == doctest::Approx(exponent).epsilon(1e-9));
  }
  CHECK_THROWS_AS(growth_exponent(std::vector{1.0, 1.0}, std::vector{1.0, 2.0}),
                  std::invalid_argument);
  CHECK_THROWS_AS(growth_exponent(std::vector{1.0, 2.0}, std::vector{0.0, 2.0}),
                  std::invalid_argument);
  CHECK_THROWS_AS(growth_exponent(std::vector{1.0, 2.0}, std::vector{2.0}), std::invalid_argument);
}

TEST_CASE("medians and spreads") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 2, 3}) == 2.5);
  CHECK_THROWS_AS(median({}), std::invalid_argument);
  const Spread spread = spread_of(std::vector{2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0});
  CHECK(spread.mean == doctest::Approx(5));
  CHECK(spread.deviation == doctest::Approx(2));
  CHECK(spread.least == 2);
  CHECK(spread.most == 9);
}

TEST_CASE("figures have the digits asked for") {
  CHECK(figure(473.72) == "474");
  CHECK(figure(0.117) == "0.117");
  CHECK(figure(0.00430, 2) == "0.0043");
  CHECK(figure(12.345, 4) == "12.35");
  CHECK(figure(51234, 2) == "51234");
  CHECK(figure(0) == "0.00");
  CHECK(figure(NAN) == "\xE2\x80\x93");
}

TEST_CASE("what happens in a child comes back") {
  const Json value = run_in_child([] { return Json{{"answer", 42}}; });
  CHECK(value["answer"] == 42);
  CHECK(value["peak_memory_bytes"].get<std::int64_t>() > 100'000);
  CHECK_THROWS_WITH(run_in_child([]() -> Json { throw std::runtime_error("no such luck"); }),
                    "no such luck");
}

TEST_CASE("a child's peak memory is its own") {
  const auto peak = [](std::size_t bytes) {
    return run_in_child([bytes] {
             std::vector<char> block(bytes, 'x');
             return Json{{"last", std::string(1, block.back())}};
           })["peak_memory_bytes"]
        .get<double>();
  };
  const double large = peak(64'000'000);
  const double small = peak(1000);
  CHECK(large - small > 50e6);
}

TEST_CASE("axes hold their values, and plots show each series") {
  Plot plot;
  plot.title = "a < b";
  plot.series = {{"one", {1, 10, 100}, {2, 20, 200}}, {"two", {1, 10}, {5, NAN}}};
  plot.x = axis_for("x", {plot.series[0].x}, true);
  plot.y = axis_for("y", {plot.series[0].y, plot.series[1].y}, true);
  CHECK(plot.x.least < 1);
  CHECK(plot.x.most > 100);
  const std::string svg = draw(plot);
  for (const char* part : {"a &lt; b", ">one<", ">two<", ">x<", ">y<", ">10<", ">100<"}) {
    CAPTURE(part);
    CHECK(svg.find(part) != std::string::npos);
  }
  CHECK(svg.find("nan") == std::string::npos);
  CHECK_THROWS_AS(axis_for("x", {{0, 1}}, true), std::invalid_argument);
  CHECK_THROWS_AS(axis_for("x", {{}}, false), std::invalid_argument);
}

TEST_CASE("a run of one size becomes tables and plots") {
  const test::TemporaryDirectory directory;
  Scale quick;
  quick.quick = true;
  Record record("table1", quick, directory.path());
  const auto add = [&](const char* row, bool paper, double seconds) {
    Json run = {{"column", "256x64"}, {"row", row}, {"description", row}, {"paper_row", paper}};
    if (seconds > 0) {
      run["result"] = {{"seconds", repeated({seconds})},
                       {"flann_ratio", repeated({seconds / 2})},
                       {"normalized_energy", repeated({0.17})},
                       {"peak_memory_bytes", repeated({1e6})},
                       {"iterations", 7},
                       {"pairs", 100},
                       {"swaps", 10},
                       {"threads", 1},
                       {"capacities_exact", true},
                       {"capacity_error", 0.0},
                       {"termination", "stable"}};
    } else {
      run["estimate"] = {{"seconds", 7200.0}};
    }
    record.json["runs"].push_back(run);
  };
  add("balzer2009", true, 0);
  add("pruned", true, 3);
  add("median-cut", true, 1.5);
  add("default", false, 0.25);
  record.save();
  const std::string text = report(directory.path());
  CHECK(text.find("N/A, about 7200") != std::string::npos);
  CHECK(text.find("| `pruned` | `median-cut` | 2.00 |") != std::string::npos);
  CHECK(text.find("Fastest on one thread: `default`") != std::string::npos);
  CHECK(text.find("1 rows N/A") != std::string::npos);
  CHECK(test::get(directory.path() / "report.md") == text);
  CHECK(test::get(directory.path() / "table1.svg").find("median-cut") != std::string::npos);
}

TEST_CASE("runs of many points a site become tables and plots") {
  const test::TemporaryDirectory directory;
  Record record("growth", Scale{}, directory.path());
  const auto add = [&](const char* table, Index points_per_site, const char* until,
                       double seconds) -> Json& {
    record.json["runs"].push_back({{"table", table},
                                   {"problem", "2D box"},
                                   {"sites", 64},
                                   {"points_per_site", points_per_site},
                                   {"threads", 1},
                                   {"until", until},
                                   {"seconds", repeated({seconds})},
                                   {"iterations", 7},
                                   {"normalized_energy", 0.17},
                                   {"reference", seconds == 1},
                                   {"times_reference", repeated({seconds})}});
    return record.json["runs"].back();
  };
  add("box", 256, "stable", 1);
  add("box", 1024, "stable", 2)["times_flann"] = repeated({0.71});
  add("box", 4096, "stable", 4)["wanted"] = {{"figure", "times_reference"}, {"most", 1.5}};
  add("box", 16384, "stable", 32)["wanted"] = {{"figure", "seconds"}, {"most", 33}};
  add("others", 4096, "stable", 2)["capacities"] = {29, 5000};
  add("threads", 4096, "stable", 0.5)["beside"] = repeated({0.625});
  record.json["parameters"]["order"] = {{"sites", 64}, {"sets", 5}};
  for (const char* until : {"stable", "blue_noise"}) {
    Json& run = add("order", 4096, until, 2);
    run["normalized_energy"] = repeated({0.17});
    for (const char* key :
         {"peak", "psi6", "smallest_distance", "mean_distance", "low_frequency_power"}) {
      run[key] = 0.5;
    }
  }
  record.save();
  const std::string text = report(directory.path());
  for (const char* part :
       {"| 65536 | 64x1024 | 2.00 |", "| 0.710 |", "at most 1.5 times the reference: not reached",
        "at most 33 s: reached", "| 64 | 1024 to 16384 | 1.00 | 1.50 |",
        "2D box, capacities 29 to 5000", "| 64x4096 | 1 | 0.500 | 2.00 |",
        "| 64x4096 | 1, two runs at once | 0.625 | 1.60 |", "| 4096 | blue_noise |", "(growth.svg)",
        "(growth_order.svg)"}) {
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  }
  const std::string picture = test::get(directory.path() / "growth_order.svg");
  for (const char* part :
       {"highest power", "psi6", "smallest distance", "low-frequency", ">stable<"}) {
    CAPTURE(part);
    CHECK(picture.find(part) != std::string::npos);
  }
}

TEST_CASE("reports of nothing, and of other files, are refused") {
  const test::TemporaryDirectory directory;
  CHECK_THROWS_AS(report(directory.path()), IoError);
  write_text(directory.path() / "scaling.json", "{\"runs\": [{\"sweep\": 1}]}");
  CHECK_THROWS_AS(report(directory.path()), InvalidInput);
  write_text(directory.path() / "scaling.json", "{");
  CHECK_THROWS_AS(report(directory.path()), InvalidInput);
}

TEST_CASE("searches of lists find what a look at each list finds") {
  constexpr Index kQueries = 200;
  Points<float> vectors =
      test::make_points<float>(test::Layout::clusters, test::uneven_box(5), 900);
  Points<float> queries =
      test::make_points<float>(test::Layout::random, test::uneven_box(5), kQueries, 9);
  // Far from the origin.
  vectors.array() += 1000;
  queries.array() += 1000;
  std::vector<Index> capacities(12, 40);
  capacities[3] = 460;
  const auto training = train_codebook(vectors, 12, {.seed = 3, .capacities = capacities});
  const auto neighbours = true_neighbours(vectors, queries, 1);
  REQUIRE(neighbours.size() == kQueries);
  for (const Coding coding : {Coding::nearest, Coding::weighted}) {
    const auto probes = probe_lists(training.codebook, training.codes, queries, neighbours, coding);
    REQUIRE(probes.size() == 5);  // 1, 2, 4, 8, 12 lists
    for (const Probe& probe : probes) {
      CAPTURE(probe.lists);
      double first = 0;
      double ten = 0;
      std::vector<double> scanned;
      for (Index q = 0; q < kQueries; ++q) {
        const Eigen::VectorXd query = queries.col(q).cast<double>();
        std::vector<std::pair<double, Index>> lists;
        for (Index s = 0; s < 12; ++s) {
          lists.emplace_back((training.codebook.codewords().col(s) - query).squaredNorm() -
                                 (coding == Coding::weighted ? training.codebook.weights()[s] : 0),
                             s);
        }
        std::sort(lists.begin(), lists.end());
        std::vector<std::pair<double, Index>> nearest;
        for (Index p = 0; p < 900; ++p) {
          nearest.emplace_back((vectors.col(p).cast<double>() - query).squaredNorm(), p);
        }
        std::sort(nearest.begin(), nearest.end());
        scanned.push_back(0);
        for (Index k = 0; k < probe.lists; ++k) {
          for (std::size_t p = 0; p < 900; ++p) {
            scanned.back() += training.codes[p] == lists[static_cast<std::size_t>(k)].second;
          }
          for (std::size_t near = 0; near < 10; ++near) {
            const auto p = static_cast<std::size_t>(nearest[near].second);
            if (training.codes[p] != lists[static_cast<std::size_t>(k)].second) continue;
            first += near == 0 ? 1 : 0;
            ten += 0.1;
          }
        }
      }
      CHECK(probe.recall_1 == doctest::Approx(first / kQueries));
      CHECK(probe.recall_10 == doctest::Approx(ten / kQueries));
      CHECK(probe.scanned_mean ==
            doctest::Approx(std::accumulate(scanned.begin(), scanned.end(), 0.0) / kQueries));
      std::sort(scanned.begin(), scanned.end());
      CHECK(probe.scanned_99 == scanned[197]);  // no more than that for 198 of 200
    }
    CHECK(probes.back().recall_10 == 1);
    CHECK(probes.back().scanned_mean == 900);
  }
}

TEST_CASE("searches of lists become tables and plots") {
  const test::TemporaryDirectory directory;
  Record record("search", Scale{}, directory.path());
  record.json["parameters"] = {{"data", "some 900 x 5"}, {"codewords", 4}, {"queries", 40}};
  const auto probes = [](double recall, double scanned) {
    return Json::array({{{"lists", 1},
                         {"recall_1", recall},
                         {"recall_10", recall},
                         {"scanned_mean", scanned},
                         {"scanned_99", 2 * scanned}},
                        {{"lists", 4},
                         {"recall_1", 1},
                         {"recall_10", 1},
                         {"scanned_mean", 900},
                         {"scanned_99", 900}}});
  };
  const Json run = {{"seconds", 2.5}, {"distortion", 0.5}, {"shortest", 225},
                    {"longest", 226}, {"imbalance", 1},    {"by_distance", probes(0.6, 100)}};
  record.json["runs"] = {run, run};
  record.json["runs"][0]["codebook"] = "balanced";
  record.json["runs"][0]["by_weight"] = probes(0.8, 300);
  record.json["runs"][1]["codebook"] = "Lloyd";
  record.save();
  const std::string text = report(directory.path());
  for (const char* part :
       {"some 900 x 5, 4 lists, 40 queries", "| balanced | 2.50 | 0.50000 | 225 | 226 |",
        "| 80 % | balanced, by distance | 500.0 | 550.0 |",
        "| 80 % | balanced, by weight | 300.0 | 600.0 |", "| 80 % | Lloyd | 500.0 |",
        "| Lloyd | 1 | 0.6000 | 0.6000 | 100.0 | 200.0 |", "(search_mean.svg)",
        "(search_99.svg)"}) {
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  }
  CHECK(test::get(directory.path() / "search_99.svg").find("balanced, by weight") !=
        std::string::npos);
}

TEST_SUITE_END();

}  // namespace ccvt::bench

#endif
