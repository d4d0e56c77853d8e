#include "relax/loans.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "schedule/tiling.h"

namespace {

using ccvt::Candidate;
using ccvt::Index;
using ccvt::Loans;
using ccvt::SiteNumber;

constexpr SiteNumber kSite(1);
using Places = std::optional<std::vector<Index>>;

Loans loans_of_two_sites() {
  Loans loans;
  loans.begin(ccvt::Tiling(2, 1));
  return loans;
}

/// A cell on one rank, with what this rank knows of others' cells.
struct Copy {
  Loans loans = loans_of_two_sites();
  std::array<int, 16> places{};

  void change(std::mt19937& random, int value) {
    std::vector<Candidate> changed(1 + random() % 3);
    for (Candidate& point : changed) {
      point.place = static_cast<Index>(random() % places.size());
      places[static_cast<std::size_t>(point.place)] = value;
    }
    loans.note_change(kSite, changed);
  }
  void sort(std::mt19937& random) {
    std::shuffle(places.begin(), places.end(), random);
    loans.note_sorting(kSite);
  }
  void copy(const Copy& from, const Places& which) {
    if (!which) {
      places = from.places;
      return;
    }
    for (const Index k : *which) {
      places[static_cast<std::size_t>(k)] = from.places[static_cast<std::size_t>(k)];
    }
  }
};

TEST_SUITE("loans") {
  TEST_CASE("no more than what has changed is sent, and the cell is the same afterwards") {
    constexpr Index kLog = 8;
    std::size_t in_part = 0;
    std::size_t whole = 0;
    std::size_t nothing = 0;
    for (unsigned seed = 0; seed < 200; ++seed) {
      CAPTURE(seed);
      std::mt19937 random(seed);
      Copy home;
      std::vector<Copy> others(3);
      int value = 0;
      const auto count = [&](const Places& places) { ++(places ? in_part : whole); };
      for (int turn = 0; turn < 60; ++turn) {
        for (auto n = random() % 3; n > 0; --n) home.change(random, ++value);
        if (random() % 16 == 0) home.sort(random);
        const auto rank = static_cast<int>(random() % others.size());
        Copy& other = others[static_cast<std::size_t>(rank)];
        if (home.loans.has(rank, kSite)) {
          ++nothing;
        } else {
          home.loans.follow(kSite, kLog);
          const auto there = home.loans.give(kSite, rank);
          const Places places = home.loans.changed_since(kSite, there, 8);
          other.copy(home, places);
          other.loans.borrow(kSite, home.loans.version(kSite));
          other.loans.follow(kSite, kLog);
          count(places);
        }
        REQUIRE(other.places == home.places);
        if (random() % 16 == 0) other.sort(random);
        for (auto n = random() % 3; n > 0; --n) other.change(random, ++value);
        if (!other.loans.has_changed(kSite)) {
          ++nothing;
        } else {
          const auto there = other.loans.give_back(kSite);
          const Places places = other.loans.changed_since(kSite, there, 8);
          home.copy(other, places);
          home.loans.take_back(kSite, other.loans.version(kSite), places);
          home.loans.give(kSite, rank);
          count(places);
        }
        REQUIRE(home.places == other.places);
        REQUIRE(home.loans.has(rank, kSite));
        REQUIRE_FALSE(other.loans.has_changed(kSite));
      }
    }
    CHECK(in_part > 10000);
    CHECK(whole > 500);
    CHECK(nothing > 3000);
  }

  TEST_CASE("places are told once, ascending, unless too many have changed since") {
    Loans loans = loans_of_two_sites();
    loans.follow(kSite, 4);
    loans.note_change(kSite, {{0, 7}, {0, 3}});  // version 1
    loans.note_change(kSite, {{0, 7}});          // 2
    CHECK(loans.version(kSite) == 2);
    CHECK(loans.changed_since(kSite, 0, 8) == std::vector<Index>{3, 7});
    CHECK(loans.changed_since(kSite, 1, 8) == std::vector<Index>{7});
    CHECK(loans.changed_since(kSite, 2, 8) == std::vector<Index>{});
    CHECK_FALSE(loans.changed_since(kSite, 0, 1));
    CHECK_FALSE(loans.changed_since(kSite, {}, 8));
    loans.note_change(kSite, {{0, 1}, {0, 2}});  // 3: the log forgets version 1
    CHECK_FALSE(loans.changed_since(kSite, 0, 8));
    CHECK(loans.changed_since(kSite, 1, 8) == std::vector<Index>{1, 2, 7});
    loans.note_sorting(kSite);  // 4
    CHECK(loans.version(kSite) == 4);
    CHECK_FALSE(loans.changed_since(kSite, 3, 8));
    CHECK(loans.changed_since(kSite, 4, 8) == std::vector<Index>{});
    loans.note_change(kSite, {{0, 5}});  // 5
    CHECK(loans.changed_since(kSite, 4, 8) == std::vector<Index>{5});
    loans.note_change(SiteNumber(0), {{0, 1}});
    CHECK_FALSE(loans.changed_since(SiteNumber(0), 0, 8));  // not followed
  }
}

}  // namespace
