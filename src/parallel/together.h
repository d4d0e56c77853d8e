#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/ranks.h"
#include "ccvt/types.h"
#include "parallel/bytes.h"

/// What ranks find out together. Of a problem that has none (null), a rank's own is all there is.
namespace ccvt {

/// What came is no answer to what was asked.
[[noreturn]] inline void refuse_other_calls() {
  throw InvalidInput(
      "ranks: have made different calls, such as set_domain() or set_initial_owners() on some of "
      "them only: all must make the same, one after the other");
}

/// A value of each rank.
template <class T>
std::vector<T> of_all(Ranks* ranks, const T& own) {
  if (ranks == nullptr) return {own};
  ByteWriter message;
  message.put(own);
  std::vector<T> all;
  for (const Ranks::Bytes& bytes : ranks->gather(message.bytes)) {
    if (bytes.size() != message.bytes.size()) refuse_other_calls();
    all.push_back(ByteReader(bytes).get<T>());
  }
  return all;
}

/// Values of all ranks, one rank's after the other's, `counts` of each: `all` has them afterwards.
template <class T>
void put_together(Ranks& ranks, std::span<const T> own, std::vector<std::size_t> counts,
                  std::span<T> all) {
  if (all.empty()) return;
  const std::size_t before =
      std::accumulate(counts.begin(), counts.begin() + ranks.rank(), std::size_t{0});
  std::copy(own.begin(), own.end(), all.begin() + static_cast<std::ptrdiff_t>(before));
  for (std::size_t& bytes : counts) bytes *= sizeof(T);
  ranks.share(std::as_writable_bytes(all), counts);
}

/// The same, with memory for them.
template <class T>
std::vector<T> joined(Ranks* ranks, std::vector<T> own, std::vector<std::size_t> counts) {
  if (ranks == nullptr) return own;
  std::vector<T> all(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
  put_together<T>(*ranks, own, std::move(counts), all);
  return all;
}
template <class T>
std::vector<T> joined(Ranks* ranks, std::vector<T> own) {
  const std::size_t count = own.size();
  return joined(ranks, std::move(own), of_all(ranks, count));
}

/// Sums of the values of all ranks, which have as many: one by one.
template <class T>
std::vector<T> summed(Ranks* ranks, std::vector<T> own) {
  if (ranks == nullptr) return own;
  const std::size_t count = own.size();
  const auto all = static_cast<std::size_t>(ranks->count());
  own = joined(ranks, std::move(own), std::vector<std::size_t>(all, count));
  for (std::size_t k = count; k < own.size(); ++k) own[k % count] += own[k];
  own.resize(count);
  return own;
}

/// Sends a message to each rank; what has come from each.
inline std::vector<Ranks::Bytes> exchanged(Ranks& ranks, std::vector<ByteWriter> messages) {
  std::vector<Ranks::Bytes> bytes;
  for (ByteWriter& message : messages) bytes.push_back(std::move(message.bytes));
  return ranks.exchange(std::move(bytes));
}

inline std::int64_t total(Ranks* ranks, std::int64_t own) {
  if (ranks == nullptr) return own;
  const std::vector<std::int64_t> all = of_all(ranks, own);
  return std::accumulate(all.begin(), all.end(), std::int64_t{0});
}

/// Of what ranks have one after the other: the number of this rank's first, and how many there are.
struct PartOfAll {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

inline PartOfAll part_of_all(Ranks* ranks, std::int64_t own) {
  PartOfAll part;
  const std::vector<std::int64_t> counts = of_all(ranks, own);
  for (std::size_t rank = 0; rank < counts.size(); ++rank) {
    if (ranks != nullptr && std::cmp_less(rank, ranks->rank())) part.first += counts[rank];
    part.count += counts[rank];
  }
  return part;
}

inline bool any(Ranks* ranks, bool own) { return total(ranks, own ? 1 : 0) > 0; }

/// Throws on all ranks what has failed on one: on the lowest one, where several have; nothing where
/// none has. `own` of this rank may be null.
inline void throw_first(Ranks& ranks, const std::exception_ptr& own) {
  enum class Kind : std::uint8_t { input, io, memory, other };
  constexpr std::uint64_t kFailed = 0x64656c6961663a72;  // no message of another kind begins so
  ByteWriter message;
  const auto put = [&](Kind kind, const std::string& text) {
    message.put(kFailed);
    message.put(kind);
    message.put(std::span<const char>(text));
  };
  try {
    if (own) std::rethrow_exception(own);
  } catch (const InvalidInput& error) {
    put(Kind::input, error.what());
  } catch (const IoError& error) {
    put(Kind::io, error.what());
  } catch (const std::bad_alloc&) {
    put(Kind::memory, {});
  } catch (const std::exception& error) {
    put(Kind::other, error.what());
  }
  for (const Ranks::Bytes& bytes : ranks.gather(message.bytes)) {
    if (bytes.empty()) continue;
    ByteReader reader(bytes);
    constexpr std::size_t kHead = sizeof(kFailed) + sizeof(Kind);
    if (bytes.size() < kHead || reader.get<std::uint64_t>() != kFailed) refuse_other_calls();
    const std::string text(reinterpret_cast<const char*>(bytes.data() + kHead),
                           bytes.size() - kHead);
    switch (reader.get<Kind>()) {
      case Kind::input:
        throw InvalidInput(text);
      case Kind::io:
        throw IoError(text);
      case Kind::memory:
        throw std::bad_alloc();
      case Kind::other:
        throw std::runtime_error(text);
    }
  }
}

/// Calls `work` on all ranks, each for itself; an exception that it throws on one is thrown on all.
template <class Work>
void agree(Ranks* ranks, const Work& work) {
  if (ranks == nullptr) return work();
  std::exception_ptr own;
  try {
    work();
  } catch (const std::exception&) {
    own = std::current_exception();
  }
  throw_first(*ranks, own);
}

}  // namespace ccvt
