#include "cli/suggestion.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace ccvt::cli {

namespace {

/// How many letters must be left out, put in, changed or exchanged with their neighbour to make `b`
/// of `a` [Damerau 1964]. O(|a| |b|).
std::size_t edits(const std::string& a, const std::string& b) {
  const std::size_t width = b.size() + 1;
  std::vector<std::size_t> table((a.size() + 1) * width);
  const auto at = [&](std::size_t i, std::size_t j) -> std::size_t& {
    return table[i * width + j];
  };
  for (std::size_t i = 0; i <= a.size(); ++i) at(i, 0) = i;
  for (std::size_t j = 0; j <= b.size(); ++j) at(0, j) = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = at(i - 1, j - 1) + (a[i - 1] == b[j - 1] ? 0 : 1);
      at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, changed});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
      }
    }
  }
  return at(a.size(), b.size());
}

}  // namespace

std::string likely_meant(const std::string& typed, const std::vector<std::string>& known) {
  constexpr std::size_t kLongest = 64;  // nobody mistypes a longer one
  constexpr std::size_t kFewest = 3;
  const std::size_t letters = typed.size() - std::min(typed.find_first_not_of('-'), typed.size());
  if (typed.size() > kLongest || letters == 0) return {};
  std::string best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  bool single = false;
  for (const std::string& word : known) {
    const bool begun = letters >= kFewest && word.starts_with(typed);
    const std::size_t distance = begun ? 0 : edits(typed, word);
    if (!begun && 3 * distance > letters + 2) continue;
    if (distance < least) {
      least = distance;
      best = word;
      single = true;
    } else if (distance == least && word != best) {
      single = false;
    }
  }
  return single ? best : std::string();
}

}  // namespace ccvt::cli
