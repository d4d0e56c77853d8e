// What Ranks and MessageProgress have once in the library, their tables of virtual functions among
// it: whoever derives from them links these, and the binary interface says what they hold.
#include "ccvt/ranks.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ccvt {

Ranks::~Ranks() = default;

void Ranks::share(std::span<std::byte> all, std::span<const std::size_t> sizes) {
  const auto own = static_cast<std::size_t>(rank());
  const std::size_t before = std::accumulate(sizes.begin(), sizes.begin() + rank(), std::size_t{0});
  std::byte* next = all.data();
  for (const Bytes& part : gather(all.subspan(before, sizes[own]))) {
    next = std::copy(part.begin(), part.end(), next);
  }
}

void Ranks::exchange_parts(std::span<const std::span<const std::byte>> to,
                           std::span<const std::span<std::byte>> from) {
  std::vector<Bytes> messages(to.size());
  for (std::size_t r = 0; r < to.size(); ++r) {
    if (std::cmp_not_equal(r, rank())) messages[r].assign(to[r].begin(), to[r].end());
  }
  messages = exchange(std::move(messages));
  for (std::size_t r = 0; r < from.size(); ++r) {
    if (std::cmp_not_equal(r, rank())) {
      std::copy(messages[r].begin(), messages[r].end(), from[r].begin());
    }
  }
}

bool Ranks::has_come([[maybe_unused]] int from) { return false; }

MessageProgress::~MessageProgress() = default;

}  // namespace ccvt
