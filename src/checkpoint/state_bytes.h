#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace ccvt {

/// Thrown by StateReader: what is read is not what was written.
struct Damaged {};

/// What can be kept as it lies in memory: no part of it is without a value.
template <class T>
inline constexpr bool is_plain = std::is_trivially_copyable_v<T> &&
                                 (std::is_arithmetic_v<T> ||
                                  std::has_unique_object_representations_v<T>);

/// The state of a run as bytes: values one after the other, in this machine's order.
class StateWriter {
 public:
  StateWriter() = default;
  /// With room for so many bytes.
  explicit StateWriter(std::size_t room) { bytes_.reserve(room); }

  template <class T>
  void put(const T& value) {
    static_assert(is_plain<T>);
    put_bytes(&value, sizeof(T));
  }
  /// How many there are, and each.
  template <class T>
  void put_all(const std::vector<T>& values) {
    static_assert(is_plain<T>);
    put(std::uint64_t{values.size()});
    put_bytes(values.data(), values.size() * sizeof(T));
  }

  /// The values alone: their number is known elsewhere.
  template <class T>
  void put_each(std::span<const T> values) {
    static_assert(is_plain<T>);
    put_bytes(values.data(), values.size_bytes());
  }
  /// Zeros in the place of bytes.
  void put_nothing(std::size_t count) { bytes_.resize(bytes_.size() + count); }

  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  void put_bytes(const void* data, std::size_t count) {
    const auto* const begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + count);
  }

  std::vector<std::byte> bytes_;
};

/// Reads them again, in the same order. Whatever the bytes are, it takes no more memory than they
/// do.
class StateReader {
 public:
  /// `bytes` must outlive it.
  explicit StateReader(std::span<const std::byte> bytes) : left_(bytes) {}

  template <class T>
  T get() {
    static_assert(is_plain<T>);
    if constexpr (std::is_same_v<T, bool>) {
      return get<std::uint8_t>() != 0;
    } else {
      T value;
      std::memcpy(&value, take(sizeof(T)), sizeof(T));
      return value;
    }
  }
  template <class T>
  std::vector<T> get_all() {
    static_assert(is_plain<T>);
    const auto count = get<std::uint64_t>();
    if (count > left_.size() / sizeof(T)) throw Damaged();
    std::vector<T> values(static_cast<std::size_t>(count));
    if (count > 0)
      std::memcpy(values.data(), take(values.size() * sizeof(T)), values.size() * sizeof(T));
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
  template <class T>
  void get_each(std::span<T> values) {
    static_assert(is_plain<T>);
    const std::byte* const from = take(values.size_bytes());
    if (!values.empty()) std::memcpy(values.data(), from, values.size_bytes());
  }
  void skip(std::size_t count) { take(count); }
  void expect_end() const {
    if (!left_.empty()) throw Damaged();
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

}  // namespace ccvt
