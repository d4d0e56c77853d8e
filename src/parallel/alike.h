#pragma once

#include <span>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/ranks.h"
#include "number_text.h"
#include "parallel/bytes.h"

namespace ccvt {

/// Something that a result follows from, in words.
struct Given {
  std::string name;
  std::string value;
  bool said = true;  ///< the value says something to people
};

/// Throws InvalidInput on all ranks where one of them was given another thing than rank 0: they
/// would wait for each other forever. All have the same names.
inline void require_alike(Ranks& ranks, std::span<const Given> own) {
  ByteWriter message;
  for (const Given& given : own) put_text(message, given.value);
  const std::vector<Ranks::Bytes> all = ranks.gather(message.bytes);
  for (std::size_t rank = 1; rank < all.size(); ++rank) {
    if (all[rank] == all[0]) continue;
    ByteReader here(all[rank]);
    ByteReader there(all[0]);
    for (const Given& given : own) {
      const std::string value = get_text(here);
      const std::string first = get_text(there);
      if (value == first) continue;
      if (!given.said) {
        throw InvalidInput(
            concat(given.name, ": rank ", rank, " and rank 0 must be given the same"));
      }
      throw InvalidInput(concat(given.name, " is ", value, " on rank ", rank, ", but ", first,
                                " on rank 0: all ranks must be given the same"));
    }
  }
}

}  // namespace ccvt
