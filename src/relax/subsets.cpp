#include "relax/subsets.h"

#include <algorithm>
#include <cmath>

#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// Of rows of so many values, one after the other, the sum of each column.
std::vector<std::size_t> sums_of(const std::vector<std::size_t>& rows, std::size_t columns) {
  std::vector<std::size_t> sums(columns, 0);
  for (std::size_t k = 0; k < rows.size(); ++k) sums[k % columns] += rows[k];
  return sums;
}

}  // namespace

/// Where the last key of a subset is looked for: from `low` to `high`.
struct NestedSubsets::Window {
  std::uint64_t low;
  std::uint64_t high;

  /// Around the key expected to be the last of `size`, `deviations` standard deviations on each
  /// side.
  static Window around(std::size_t size, std::size_t places, double deviations) {
    const auto all = static_cast<double>(places);
    const double share = static_cast<double>(size) / all;
    const double room = deviations * std::sqrt(share * (1 - share) / all) + 2 * deviations / all;
    const auto key = [](double part) -> std::uint64_t {
      if (part <= 0) return 0;
      return part < 1 ? static_cast<std::uint64_t>(part * 0x1p64) : UINT64_MAX;
    };
    return {key(share - room), key(share + room)};
  }
};

NestedSubsets::NestedSubsets(Order order, Random random, std::size_t places,
                             std::span<const std::size_t> sizes, const Arena& arena)
    : even_(order == Order::even), start_(random.next()), last_(sizes.size()) {
  if (sizes.empty()) return;
  std::vector<Window> windows;
  double deviations = 8;
  do {
    windows.clear();
    for (const std::size_t size : sizes)
      windows.push_back(Window::around(size, places, deviations));
    deviations *= 8;
  } while (!search(places, sizes, windows, arena));
}

/// Keys below a subset's window are counted, those inside collected; of these, the one with the
/// right rank is the last. Windows of larger subsets lie higher, so that most places are done with
/// after one comparison. False when one is outside its window.
bool NestedSubsets::search(std::size_t places, std::span<const std::size_t> sizes,
                           const std::vector<Window>& windows, const Arena& arena) {
  constexpr std::size_t kBlock = 1 << 16;
  struct Found {
    std::uint64_t key;
    std::size_t subset;
  };
  const std::size_t subsets = sizes.size();
  std::vector<std::size_t> below(((places - 1) / kBlock + 1) * subsets, 0);  // by block
  const Buffer<Found> inside = collect_together<Found>(
      arena, places, kBlock,
      [&](std::size_t begin, std::size_t end, std::vector<Found>& found, int) {
        std::size_t* const here = &below[begin / kBlock * subsets];
        for (std::size_t p = begin; p < end; ++p) {
          const std::uint64_t key = key_of(p);
          for (std::size_t s = subsets; s-- > 0 && key <= windows[s].high;) {
            if (key < windows[s].low) {
              ++here[s];
            } else {
              found.push_back({key, s});
            }
          }
        }
      });
  below = summed(arena.ranks(), sums_of(below, subsets));
  for (std::size_t s = 0; s < subsets; ++s) {
    std::vector<std::uint64_t> keys;
    for (const Found& found : inside) {
      if (found.subset == s) keys.push_back(found.key);
    }
    if (below[s] >= sizes[s] || sizes[s] - below[s] > keys.size()) return false;
    std::uint64_t* const last = keys.data() + (sizes[s] - below[s] - 1);
    std::nth_element(keys.data(), last, keys.data() + keys.size());
    last_[s] = *last;
  }
  return true;
}

}  // namespace ccvt
