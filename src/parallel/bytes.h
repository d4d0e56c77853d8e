#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace ccvt {

/// Values one after the other, as they are in memory.
class ByteWriter {
 public:
  template <class T>
  void put(const T& value) {
    put(std::span<const T>(&value, 1));
  }
  template <class T>
  void put(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (values.empty()) return;
    const auto* const from = reinterpret_cast<const std::byte*>(values.data());
    bytes.insert(bytes.end(), from, from + values.size_bytes());
  }
  /// With how many there are.
  template <class T>
  void put(const std::vector<T>& values) {
    put(values.size());
    put(std::span<const T>(values));
  }

  std::vector<std::byte> bytes;
};

/// Takes them again, in the same order. What it reads must outlive it.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : left_(bytes) {}

  [[nodiscard]] bool done() const { return left_.empty(); }
  template <class T>
  T get() {
    T value;
    get(std::span<T>(&value, 1));
    return value;
  }
  template <class T>
  void get(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (values.empty()) return;
    if (values.size_bytes() > left_.size()) throw std::logic_error("ranks: a message is too short");
    std::memcpy(values.data(), left_.data(), values.size_bytes());
    left_ = left_.subspan(values.size_bytes());
  }
  template <class T>
  void get(std::vector<T>& values) {
    const auto count = get<std::size_t>();
    if (count > left_.size() / sizeof(T)) throw std::logic_error("ranks: a message is too short");
    values.resize(count);
    get(std::span<T>(values));
  }

 private:
  std::span<const std::byte> left_;
};

}  // namespace ccvt
