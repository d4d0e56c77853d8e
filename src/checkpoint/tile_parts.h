#pragma once

#include <cstddef>
#include <exception>
#include <utility>
#include <vector>

#include "ccvt/ranks.h"
#include "schedule/tiling.h"

/// The records of tiles on their way between a file, which the first rank writes and reads, and the
/// ranks that have the tiles: so many that are in memory together, or one, at a time.
namespace ccvt {

/// Consecutive tiles of one rank.
struct TilePart {
  std::size_t first;
  std::size_t end;
  std::vector<std::size_t> offsets;  ///< where the record of each begins, and one more
  int rank = 0;                      ///< that has them
  bool begins = false;               ///< it is the first part of its rank
  bool ends = false;                 ///< and the last one

  [[nodiscard]] std::size_t bytes() const { return offsets.back(); }
};

/// `sizes`: of each tile's record.
inline std::vector<TilePart> parts_of(const Tiling& tiling, const std::vector<std::size_t>& sizes) {
  constexpr std::size_t kBytesAtOnce = std::size_t{1} << 24;
  const auto rank_of = [&](std::size_t t) {
    return tiling.ranks() == nullptr ? 0 : tiling.rank_of(Tile(t));
  };
  std::vector<TilePart> parts;
  for (std::size_t t = 0; t < sizes.size(); ++t) {
    const bool begins = t == 0 || rank_of(t - 1) != rank_of(t);
    if (begins || parts.back().bytes() + sizes[t] > kBytesAtOnce) {
      parts.push_back({t, t, {0}, rank_of(t), begins, false});
    }
    TilePart& part = parts.back();
    part.offsets.push_back(part.bytes() + sizes[t]);
    part.end = t + 1;
    part.ends = part.end == sizes.size() || rank_of(part.end) != part.rank;
  }
  return parts;
}

/// Does no more once something has failed.
class Attempts {
 public:
  template <class Work>
  void operator()(const Work& work) {
    if (failure_) return;
    try {
      work();
    } catch (...) {
      failure_ = std::current_exception();
    }
  }
  [[nodiscard]] bool failed() const { return failure_ != nullptr; }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::exception_ptr failure_;
};

/// On a rank that is not the first: sends it the bytes of its parts, for as long as it wants them.
/// None where they cannot be made.
template <class Make>
void send_parts(Ranks& ranks, const std::vector<TilePart>& parts, const Make& make) {
  Attempts attempt;
  for (const TilePart& part : parts) {
    if (part.rank != ranks.rank()) continue;
    Ranks::Bytes bytes;
    attempt([&] { bytes = make(part); });
    ranks.send(0, std::move(bytes));
    if (attempt.failed() || part.ends || ranks.receive(0)[0] == std::byte{0}) break;
  }
  attempt.rethrow();
}

/// On the first rank, or where there are none.
template <class Make, class Take>
void collect_parts(Ranks* ranks, const std::vector<TilePart>& parts, const Make& make,
                   const Take& take) {
  Attempts attempt;
  bool lacking = false;  // of what others were to make
  int silent = 0;        // the rank from which nothing comes any more
  for (const TilePart& part : parts) {
    Ranks::Bytes bytes;
    if (part.rank == 0) {
      attempt([&] { bytes = make(part); });
    } else if (part.rank == silent) {
      continue;
    } else {
      bytes = ranks->receive(part.rank);
      lacking = lacking || bytes.empty();
      const bool goes_on = !lacking && !attempt.failed();
      if (!goes_on) silent = part.rank;
      if (!bytes.empty() && !part.ends) ranks->send(part.rank, {std::byte{goes_on}});
    }
    if (!lacking) attempt([&] { take(bytes); });
  }
  attempt.rethrow();
}

/// The bytes of each part, make(part) on its rank, are handed to take(bytes) on the first, in their
/// order: while that takes a part, the next one is made. Where something fails, it is thrown on the
/// rank where it does, and the others know nothing: all must agree() on it. No message is left.
template <class Make, class Take>
void parts_to_first(Ranks* ranks, const std::vector<TilePart>& parts, const Make& make,
                    const Take& take) {
  if (ranks != nullptr && ranks->rank() > 0) return send_parts(*ranks, parts, make);
  collect_parts(ranks, parts, make, take);
}

/// On a rank that is not the first: takes what that sends, and says so.
template <class Take>
void take_parts(Ranks& ranks, const std::vector<TilePart>& parts, const Take& take) {
  Attempts attempt;
  for (const TilePart& part : parts) {
    if (part.rank != ranks.rank()) continue;
    const Ranks::Bytes bytes = ranks.receive(0);
    if (bytes.empty()) break;
    attempt([&] { take(part, bytes); });
    if (!part.ends) ranks.send(0, {std::byte{1}});
  }
  attempt.rethrow();
}

/// On the first rank, or where there are none: sends no bytes to a rank for which there are none.
template <class Make, class Take>
void deal_parts(Ranks* ranks, const std::vector<TilePart>& parts, const Make& make,
                const Take& take) {
  Attempts attempt;
  int silent = 0;  // the rank to which nothing is sent any more
  for (const TilePart& part : parts) {
    Ranks::Bytes bytes;
    attempt([&] { bytes = make(part); });
    if (part.rank == 0) {
      attempt([&] { take(part, bytes); });
    } else if (part.rank != silent) {
      if (!part.begins) static_cast<void>(ranks->receive(part.rank));  // it has taken the last one
      if (attempt.failed()) {
        silent = part.rank;
        bytes.clear();
      }
      ranks->send(part.rank, std::move(bytes));
    }
  }
  attempt.rethrow();
}

/// The other way: make(part) on the first rank, take(part, bytes) on that of the part.
template <class Make, class Take>
void parts_from_first(Ranks* ranks, const std::vector<TilePart>& parts, const Make& make,
                      const Take& take) {
  if (ranks != nullptr && ranks->rank() > 0) return take_parts(*ranks, parts, take);
  deal_parts(ranks, parts, make, take);
}

}  // namespace ccvt
