#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace ccvt {

/// Thrown by ByteReader: what is read is not what was written.
struct Damaged : std::runtime_error {
  Damaged() : std::runtime_error("what was read is not what was written") {}
};

template <class T>
inline constexpr bool is_span = false;
template <class T, std::size_t Extent>
inline constexpr bool is_span<std::span<T, Extent>> = true;

/// What can be kept as it lies in memory: no part of it is without a value, or elsewhere.
template <class T>
inline constexpr bool is_plain =
    std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !is_span<T> &&
    (std::is_arithmetic_v<T> || std::has_unique_object_representations_v<T>);

/// Values one after the other, in this machine's order: for other ranks, and for files.
class ByteWriter {
 public:
  ByteWriter() = default;
  /// With room for so many bytes.
  explicit ByteWriter(std::size_t room) { bytes.reserve(room); }

  template <class T>
  void put(const T& value) {
    put(std::span<const T>(&value, 1));
  }
  /// The values alone: their number is known elsewhere.
  template <class T>
  void put(std::span<const T> values) {
    static_assert(is_plain<T>);
    if (values.empty()) return;
    const auto* const from = reinterpret_cast<const std::byte*>(values.data());
    bytes.insert(bytes.end(), from, from + values.size_bytes());
  }
  /// With how many there are.
  template <class T>
  void put(const std::vector<T>& values) {
    put(std::uint64_t{values.size()});
    put(std::span<const T>(values));
  }
  /// Zeros in the place of bytes.
  void put_nothing(std::size_t count) { bytes.resize(bytes.size() + count); }

  std::vector<std::byte> bytes;
};

/// Takes them again, in the same order. Whatever the bytes are, it takes no more memory than they
/// do; where they are not what is asked for, it throws Damaged.
class ByteReader {
 public:
  /// `bytes` must outlive it.
  explicit ByteReader(std::span<const std::byte> bytes) : left_(bytes) {}

  [[nodiscard]] bool done() const { return left_.empty(); }
  template <class T>
  T get() {
    if constexpr (std::is_same_v<T, bool>) {
      return get<std::uint8_t>() != 0;
    } else {
      T value;
      get(std::span<T>(&value, 1));
      return value;
    }
  }
  template <class T>
  void get(std::span<T> values) {
    static_assert(is_plain<T>);
    if (values.empty()) return;
    std::memcpy(values.data(), take(values.size_bytes()), values.size_bytes());
  }
  /// As many as there are.
  template <class T>
  void get(std::vector<T>& values) {
    const auto count = get<std::uint64_t>();
    if (count > left_.size() / sizeof(T)) throw Damaged();
    values.resize(static_cast<std::size_t>(count));
    get(std::span<T>(values));
  }
  template <class T>
  std::vector<T> get_all() {
    std::vector<T> values;
    get(values);
    return values;
  }
  /// As many as are expected.
  template <class T>
  std::vector<T> get_all(std::size_t count) {
    std::vector<T> values = get_all<T>();
    if (values.size() != count) throw Damaged();
    return values;
  }
  /// Numbers of things of which there are `end`.
  template <class N>
  std::vector<N> get_numbers(std::size_t end) {
    std::vector<N> numbers = get_all<N>();
    if (!std::all_of(numbers.begin(), numbers.end(), [&](N n) { return n < end; })) throw Damaged();
    return numbers;
  }
  void skip(std::size_t count) { take(count); }
  void expect_end() const {
    if (!done()) throw Damaged();
  }

 private:
  const std::byte* take(std::size_t count) {
    if (count > left_.size()) throw Damaged();
    const std::byte* const begin = left_.data();
    left_ = left_.subspan(count);
    return begin;
  }

  std::span<const std::byte> left_;
};

/// With how many letters there are.
inline void put_text(ByteWriter& out, const std::string& text) {
  out.put(std::vector<char>(text.begin(), text.end()));
}
inline std::string get_text(ByteReader& in) {
  const std::vector<char> letters = in.get_all<char>();
  return {letters.begin(), letters.end()};
}

}  // namespace ccvt
