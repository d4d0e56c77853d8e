#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "parallel/pages.h"

namespace ccvt {

/// An array whose elements have no value until they are given one, so that the worker that will use
/// a part of it is the first to touch its memory.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  Buffer() = default;
  explicit Buffer(std::size_t size) : data_(allocate(size)), size_(size), room_(size) {}
  /// Of which only `used` elements from `first` on, and few others, are ever touched.
  Buffer(std::size_t size, std::size_t first, std::size_t used) : size_(size), room_(size) {
    if (used == size) {
      data_.reset(allocate(size));
      return;
    }
    check(size);
    const Pages pages = reserve_pages(size * sizeof(T));
    data_ = {static_cast<T*>(pages.memory), Free{pages.mapped}};
    prefer_large_pages(data() + first, used * sizeof(T));
  }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer(std::move(other)).swap(*this);
    return *this;
  }
  Buffer(const Buffer& other) : Buffer(other.size_) {
    std::copy(other.begin(), other.end(), begin());
  }
  Buffer& operator=(const Buffer& other) {
    Buffer(other).swap(*this);
    return *this;
  }
  ~Buffer() = default;

  /// Makes it this large; what it held is lost. Allocates when it has never been as large, and
  /// tells whether it did.
  bool reset(std::size_t size) {
    const bool grows = size > room_;
    if (grows) *this = Buffer(size);
    size_ = size;
    return grows;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] T* begin() { return data(); }
  [[nodiscard]] const T* begin() const { return data(); }
  [[nodiscard]] T* end() { return data() + size_; }
  [[nodiscard]] const T* end() const { return data() + size_; }
  [[nodiscard]] T& operator[](std::size_t k) {
    assert(k < size_);
    return data_[k];
  }
  [[nodiscard]] const T& operator[](std::size_t k) const {
    assert(k < size_);
    return data_[k];
  }
  [[nodiscard]] std::span<T> span() { return {data(), size_}; }
  [[nodiscard]] std::span<const T> span() const { return {data(), size_}; }

 private:
  void swap(Buffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(room_, other.room_);
  }

  struct Free {
    std::size_t mapped = 0;
    void operator()(T* memory) const { free_reserved({memory, mapped}); }
  };
  static void check(std::size_t size) {
    if (size > SIZE_MAX / sizeof(T)) throw std::bad_alloc();
  }
  static T* allocate(std::size_t size) {
    check(size);
    return static_cast<T*>(allocate_pages(size * sizeof(T)));
  }

  std::unique_ptr<T[], Free> data_;
  std::size_t size_ = 0;
  std::size_t room_ = 0;
};

}  // namespace ccvt
