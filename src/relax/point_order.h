#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>

#include "numbers.h"
#include "parallel/buffer.h"
#include "parallel/bytes.h"

namespace ccvt {

/// The numbers of points, place by place: of four bytes, and where so many points are numbered that
/// these do not tell them apart, of a fifth one in an array of its own.
class PointOrder {
 public:
  /// Fewer bits are for tests, which then have numbers of two parts, too, where there are not so
  /// many that these do not tell them apart.
#ifdef CCVT_TEST_POINT_BITS
  static constexpr int kBits = CCVT_TEST_POINT_BITS;
#else
  static constexpr int kBits = 32;
  static_assert(kMostPointsOfAll == std::int64_t{1} << (kBits + 8));
#endif
  static constexpr std::int64_t kMostPointsOfFour = std::int64_t{1} << kBits;

  /// Some places that follow each other.
  class View {
   public:
    View(const std::uint32_t* low, const std::uint8_t* high, std::size_t size)
        : low_(low), high_(high), size_(size) {}
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] PointOfAll operator[](std::size_t k) const {
      const std::int64_t high = high_ == nullptr ? 0 : high_[k];
      return PointOfAll(high << kBits | low_[k]);
    }

    /// Outlives the view.
    class Iterator {
     public:
      using iterator_category = std::input_iterator_tag;
      using value_type = PointOfAll;
      using difference_type = std::ptrdiff_t;
      using pointer = const PointOfAll*;
      using reference = PointOfAll;
      Iterator(const std::uint32_t* low, const std::uint8_t* high) : low_(low), high_(high) {}
      PointOfAll operator*() const { return View(low_, high_, 1)[0]; }
      Iterator& operator++() {
        ++low_;
        if (high_ != nullptr) ++high_;
        return *this;
      }
      Iterator operator++(int) {
        const Iterator before = *this;
        ++*this;
        return before;
      }
      friend bool operator==(const Iterator& a, const Iterator& b) { return a.low_ == b.low_; }

     private:
      const std::uint32_t* low_;
      const std::uint8_t* high_;
    };
    [[nodiscard]] Iterator begin() const { return {low_, high_}; }
    [[nodiscard]] Iterator end() const { return {low_ + size_, nullptr}; }

   private:
    friend PointOrder;
    const std::uint32_t* low_;
    const std::uint8_t* high_;  ///< null: all are zero
    std::size_t size_;
  };

  PointOrder() = default;
  /// Of `places`, `used` from `first` on, and few others, are ever touched. `points`: how many are
  /// numbered.
  PointOrder(std::size_t places, std::size_t first, std::size_t used, std::int64_t points)
      : low_(places, first, used) {
    const bool two_parts = points > kMostPointsOfFour && points <= kMostPointsOfFour << 8;
    if (two_parts) high_ = Buffer<std::uint8_t>(places, first, used);
  }

  /// Of each place.
  [[nodiscard]] std::size_t bytes() const {
    return high_.empty() ? sizeof(std::uint32_t) : sizeof(std::uint32_t) + 1;
  }
  [[nodiscard]] PointOfAll operator[](std::size_t place) const { return view(place, 1)[0]; }
  [[nodiscard]] View view(std::size_t first, std::size_t count) const {
    return {low_.data() + first, high_.empty() ? nullptr : high_.data() + first, count};
  }

  void set(std::size_t place, PointOfAll point) {
    low_[place] = static_cast<std::uint32_t>(point.index());
    if (high_.empty()) return;
    low_[place] &= static_cast<std::uint32_t>(kMostPointsOfFour - 1);
    high_[place] = static_cast<std::uint8_t>(point.index() >> kBits);
  }
  void exchange(std::size_t place, std::size_t other) {
    std::swap(low_[place], low_[other]);
    if (!high_.empty()) std::swap(high_[place], high_[other]);
  }
  /// From another order of as many bytes.
  void copy(const View& from, std::size_t first) {
    std::copy_n(from.low_, from.size_, low_.data() + first);
    if (!high_.empty()) std::copy_n(from.high_, from.size_, high_.data() + first);
  }
  /// Has the memory of a place fetched, to be written.
  void prefetch(std::size_t place) const {
    __builtin_prefetch(low_.data() + place, 1);
    if (!high_.empty()) __builtin_prefetch(high_.data() + place, 1);
  }

  void write(ByteWriter& out, std::size_t first, std::size_t count) const {
    out.put(low_.span().subspan(first, count));
    if (!high_.empty()) out.put(high_.span().subspan(first, count));
  }
  void read(ByteReader& in, std::size_t first, std::size_t count) {
    in.get(low_.span().subspan(first, count));
    if (!high_.empty()) in.get(high_.span().subspan(first, count));
  }

 private:
  Buffer<std::uint32_t> low_;
  Buffer<std::uint8_t> high_;  ///< empty: all are zero
};

}  // namespace ccvt
