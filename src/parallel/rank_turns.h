#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/ranks.h"
#include "parallel/arena.h"
#include "parallel/bytes.h"
#include "parallel/rank_part.h"

namespace ccvt {

/// Those that share the work on points that all of them have: that the arena divides loops among,
/// unless the points are a rank's part. Null where nobody does.
inline Ranks* sharing(const Arena& arena, const RankPart& part) {
  return part.ranks == nullptr ? arena.ranks() : nullptr;
}

/// Of things that all ranks have, numbered from 0, those that each looks at: one after the other in
/// turn, since neighbours may be alike. Without ranks, all are one's own.
class RankTurns {
 public:
  explicit RankTurns(const Ranks* ranks = nullptr) {
    if (ranks == nullptr) return;
    own_ = static_cast<std::size_t>(ranks->rank());
    count_ = static_cast<std::size_t>(ranks->count());
  }

  [[nodiscard]] bool own(std::size_t number) const { return rank_of(number) == own_; }
  [[nodiscard]] std::size_t rank_of(std::size_t number) const { return number % count_; }
  /// Of one's own, how many come before.
  [[nodiscard]] std::size_t place_of(std::size_t number) const { return number / count_; }

 private:
  std::size_t own_ = 0;
  std::size_t count_ = 1;
};

/// Each rank has written what it found of its own, one after the other: calls read(number, reader)
/// for 0..count - 1, with what its rank has written of it next.
template <class Read>
void read_in_turns(Ranks& ranks, std::span<const std::byte> own, std::size_t count,
                   const Read& read) {
  const RankTurns turns(&ranks);
  const std::vector<Ranks::Bytes> of_ranks = ranks.gather(own);
  std::vector<ByteReader> readers(of_ranks.begin(), of_ranks.end());
  for (std::size_t number = 0; number < count; ++number) {
    read(number, readers[turns.rank_of(number)]);
  }
}

}  // namespace ccvt
