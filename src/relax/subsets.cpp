#include "relax/subsets.h"

#include <algorithm>
#include <cmath>

#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {

/// Where the last key of a subset is looked for: from `low` to `high`.
struct NestedSubsets::Window {
  std::uint64_t low;
  std::uint64_t high;

  /// Around the key expected to be the last of `size`, `deviations` standard deviations on each
  /// side.
  static Window around(std::size_t size, std::size_t points, double deviations) {
    const auto all = static_cast<double>(points);
    const double share = static_cast<double>(size) / all;
    const double room = deviations * std::sqrt(share * (1 - share) / all) + 2 * deviations / all;
    const auto key = [](double part) -> std::uint64_t {
      if (part <= 0) return 0;
      return part < 1 ? static_cast<std::uint64_t>(part * 0x1p64) : UINT64_MAX;
    };
    return {key(share - room), key(share + room)};
  }
};

NestedSubsets::NestedSubsets(std::uint64_t seed, std::uint64_t stream, std::size_t points,
                             std::span<const std::size_t> sizes, const Arena& arena)
    : start_(Random(seed, stream).next()), last_(sizes.size()) {
  if (sizes.empty()) return;
  std::vector<Window> windows;
  double deviations = 8;
  do {
    windows.clear();
    for (const std::size_t size : sizes)
      windows.push_back(Window::around(size, points, deviations));
    deviations *= 8;
  } while (!search(points, sizes, windows, arena));
}

/// Keys below a subset's window are counted, those inside collected; of these, the one with the
/// right rank is the last. Windows of larger subsets lie higher, so that most points are done with
/// after one comparison. False when one is outside its window.
bool NestedSubsets::search(std::size_t points, std::span<const std::size_t> sizes,
                           const std::vector<Window>& windows, const Arena& arena) {
  struct Found {
    std::uint64_t key;
    std::size_t subset;
    std::size_t block;
  };
  const std::size_t subsets = sizes.size();
  count_.assign(((points - 1) / kBlock + 1) * subsets, 0);
  const Buffer<Found> inside = collect_together<Found>(
      arena, points, kBlock,
      [&](std::size_t begin, std::size_t end, std::vector<Found>& found, int) {
        std::size_t* const below = &count_[begin / kBlock * subsets];
        for (std::size_t p = begin; p < end; ++p) {
          const std::uint64_t key = key_of(p);
          for (std::size_t s = subsets; s-- > 0 && key <= windows[s].high;) {
            if (key < windows[s].low) {
              ++below[s];
            } else {
              found.push_back({key, s, begin / kBlock});
            }
          }
        }
      });
  if (arena.ranks() != nullptr) {
    const RankRange own(arena.ranks(), points, kBlock);
    const auto place = [&](std::size_t point) {
      return count_.begin() + std::ptrdiff_t((point + kBlock - 1) / kBlock * subsets);
    };
    count_ = joined(arena.ranks(), std::vector<std::size_t>(place(own.begin), place(own.end)));
  }
  for (std::size_t s = 0; s < subsets; ++s) {
    std::size_t before = 0;
    for (std::size_t k = s; k < count_.size(); k += subsets) before += count_[k];
    std::vector<std::uint64_t> keys;
    for (const Found& found : inside) {
      if (found.subset == s) keys.push_back(found.key);
    }
    if (before >= sizes[s] || sizes[s] - before > keys.size()) return false;
    std::uint64_t* const last = keys.data() + (sizes[s] - before - 1);
    std::nth_element(keys.data(), last, keys.data() + keys.size());
    last_[s] = *last;
  }
  for (const auto& [key, subset, block] : inside) {
    if (key <= last_[subset]) ++count_[block * subsets + subset];
  }
  return true;
}

}  // namespace ccvt
