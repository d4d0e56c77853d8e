#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "exact_sum.h"
#include "parallel/bytes.h"
#include "parallel/loops.h"

namespace ccvt {

/// What pricing finds, whoever finds it: neither order nor parts change a sum.
struct PriceSums {
  ExactSum gap;
  ExactSum energy;
  ExactSum saved;
  double worst = 0;
  std::int64_t moved = 0;

  void add(const PriceSums& other) {
    gap.add(other.gap);
    energy.add(other.energy);
    saved.add(other.saved);
    worst = std::max(worst, other.worst);
    moved += other.moved;
  }

  /// Adds those of all other ranks.
  void add_ranks(Ranks& ranks) {
    ByteWriter message;
    message.put(gap);
    message.put(energy);
    message.put(saved);
    message.put(worst);
    message.put(moved);
    *this = {};
    for (const Ranks::Bytes& bytes : ranks.gather(message.bytes)) {
      ByteReader reader(bytes);
      PriceSums come;
      come.gap = reader.get<ExactSum>();
      come.energy = reader.get<ExactSum>();
      come.saved = reader.get<ExactSum>();
      come.worst = reader.get<double>();
      come.moved = reader.get<std::int64_t>();
      add(come);
    }
  }
};

inline ExactSum exact_sum_of(const Arena& arena, std::span<const double> terms) {
  constexpr std::size_t kTermsPerGrain = 4096;
  PerWorker<ExactSum> parts(arena);
  arena.for_ranges(terms.size(), kTermsPerGrain,
                   [&](std::size_t begin, std::size_t end, int worker) {
                     for (std::size_t k = begin; k < end; ++k) parts[worker].add(terms[k]);
                   });
  ExactSum sum;
  for (int worker = 0; worker < arena.threads(); ++worker) sum.add(parts[worker]);
  return sum;
}

}  // namespace ccvt
