#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "ccvt/ranks.h"
#include "ccvt/types.h"
#include "parallel/bytes.h"

/// What ranks find out together. Of a problem that has none (null), a rank's own is all there is.
namespace ccvt {

/// A value of each rank.
template <class T>
std::vector<T> of_all(Ranks* ranks, const T& own) {
  if (ranks == nullptr) return {own};
  ByteWriter message;
  message.put(own);
  std::vector<T> all;
  for (const Ranks::Bytes& bytes : ranks->gather(message.bytes)) {
    all.push_back(ByteReader(bytes).get<T>());
  }
  return all;
}

/// Values of all ranks, one rank's after the other's.
template <class T>
std::vector<T> joined(Ranks* ranks, std::vector<T> own) {
  if (ranks == nullptr) return own;
  const std::vector<Ranks::Bytes> parts = ranks->gather(std::as_bytes(std::span(own)));
  std::size_t bytes = 0;
  for (const Ranks::Bytes& part : parts) bytes += part.size();
  own.resize(bytes / sizeof(T));
  auto* next = reinterpret_cast<std::byte*>(own.data());
  for (const Ranks::Bytes& part : parts) next = std::copy(part.begin(), part.end(), next);
  return own;
}

inline std::int64_t total(Ranks* ranks, std::int64_t own) {
  if (ranks == nullptr) return own;
  const std::vector<std::int64_t> all = of_all(ranks, own);
  return std::accumulate(all.begin(), all.end(), std::int64_t{0});
}

inline bool any(Ranks* ranks, bool own) { return total(ranks, own ? 1 : 0) > 0; }

/// Calls `work` on all ranks; an InvalidInput that it throws on one is thrown on all: that of the
/// lowest rank, where several do.
template <class Work>
void agree(Ranks* ranks, const Work& work) {
  if (ranks == nullptr) return work();
  std::string own;
  try {
    work();
  } catch (const InvalidInput& error) {
    own = error.what();
  }
  for (const Ranks::Bytes& bytes : ranks->gather(std::as_bytes(std::span(own)))) {
    if (bytes.empty()) continue;
    throw InvalidInput({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
}

}  // namespace ccvt
