#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "random.h"

namespace ccvt {

/// 64 bits that tell bytes apart: each word of eight bytes is scrambled into what those before it
/// gave, and both steps are bijections, so that no change inside one word goes unnoticed. No
/// defence against somebody who wants it to.
inline std::uint64_t digest(std::span<const std::byte> bytes, std::uint64_t start = 0) {
  constexpr std::size_t kWord = sizeof(std::uint64_t);
  std::uint64_t result = mix_bits(start + 0x9e3779b97f4a7c15ULL + bytes.size());
  std::size_t k = 0;
  for (; k + kWord <= bytes.size(); k += kWord) {
    std::uint64_t word;
    std::memcpy(&word, &bytes[k], kWord);
    result = mix_bits(result ^ word);
  }
  std::uint64_t rest = 0;
  if (k < bytes.size()) std::memcpy(&rest, &bytes[k], bytes.size() - k);
  return mix_bits(result ^ rest);
}

template <class T>
std::uint64_t digest_of(std::span<const T> values, std::uint64_t start = 0) {
  return digest(std::as_bytes(values), start);
}

}  // namespace ccvt
