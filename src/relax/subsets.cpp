#include "relax/subsets.h"

#include <algorithm>
#include <bit>
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
  if (even_) {
    for (std::size_t s = 0; s < sizes.size(); ++s) last_[s] = even_key_of_rank(sizes[s], places);
    return;
  }
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

/// How many places have an even key up to this one. In an aligned run of 2^k of them the keys have
/// all different k highest bits, and below these the same bits: so all combinations.
std::size_t NestedSubsets::even_keys_to(std::uint64_t key, std::size_t places) const {
  std::size_t count = 0;
  std::size_t begin = 0;
  for (int k = static_cast<int>(std::bit_width(places)); k-- > 0;) {
    const std::size_t run = std::size_t{1} << static_cast<unsigned>(k);
    if ((places & run) == 0) continue;
    const std::uint64_t below = UINT64_MAX >> static_cast<unsigned>(k);
    const std::uint64_t rest = even_key(begin) & below;
    count += k == 0 ? 0 : key >> static_cast<unsigned>(64 - k);
    count += (key & below) >= rest ? 1 : 0;
    begin += run;
  }
  return count;
}

/// The greatest key in the even subset of so many places. O(log places), 64 times.
std::uint64_t NestedSubsets::even_key_of_rank(std::size_t size, std::size_t places) const {
  std::uint64_t key = UINT64_MAX;
  for (std::uint64_t step = std::uint64_t{1} << 63U; step > 0; step >>= 1U) {
    if (even_keys_to(key - step, places) >= size) key -= step;
  }
  return key;
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
