#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ccvt {

/// A sum of finite doubles that is kept exactly, so that neither the order of its terms nor how
/// they are divided into parts, among threads or ranks, can change it. Adding takes about as long
/// as a few additions.
class ExactSum {
 public:
  void add(double term) {
    const auto bits = std::bit_cast<std::uint64_t>(term);
    const auto exponent = static_cast<unsigned>(bits >> kFractionBits & 0x7ff);
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << kFractionBits) - 1);
    // The term is `whole` times two to the power of `place` - 1074.
    const std::uint64_t whole =
        exponent == 0 ? fraction : fraction | std::uint64_t{1} << kFractionBits;
    const unsigned place = exponent == 0 ? 0 : exponent - 1;
    const unsigned shift = place % kDigitBits;
    const std::uint64_t low = (whole & kMask) << shift;
    const std::uint64_t high = (whole >> kDigitBits) << shift;
    const std::int64_t sign = bits >> 63 != 0 ? -1 : 1;
    std::int64_t* const digit = digits_.data() + place / kDigitBits;
    digit[0] += sign * static_cast<std::int64_t>(low & kMask);
    digit[1] += sign * static_cast<std::int64_t>((low >> kDigitBits) + (high & kMask));
    digit[2] += sign * static_cast<std::int64_t>(high >> kDigitBits);
    if (++since_carry_ == kMostTerms) carry();
  }

  void add(const ExactSum& other) {
    carry();
    ExactSum parts = other;
    parts.carry();
    for (std::size_t k = 0; k < kDigits; ++k) digits_[k] += parts.digits_[k];
    ++since_carry_;
  }

  /// The sum less another.
  [[nodiscard]] ExactSum less(ExactSum other) const {
    for (std::int64_t& digit : other.digits_) digit = -digit;
    other.add(*this);
    return other;
  }

  /// The double nearest to it, but where it lies almost in the middle between two.
  [[nodiscard]] double value() const {
    ExactSum sum = *this;
    sum.carry();
    const bool negative = sum.digits_.back() < 0;
    if (negative) {
      for (std::int64_t& digit : sum.digits_) digit = -digit;
      sum.carry();
    }
    double value = 0;
    for (std::size_t k = 0; k < kDigits; ++k) {
      if (sum.digits_[k] == 0) continue;
      value += std::ldexp(static_cast<double>(sum.digits_[k]),
                          static_cast<int>(k) * static_cast<int>(kDigitBits) - kLeastExponent);
    }
    return negative ? -value : value;
  }

 private:
  static constexpr unsigned kFractionBits = 52;
  static constexpr unsigned kDigitBits = 32;
  static constexpr std::uint64_t kMask = 0xffffffff;
  static constexpr int kLeastExponent = 1074;
  /// All that doubles have, and room above for 2^62 of the largest.
  static constexpr std::size_t kDigits = 68;
  /// So many terms, of less than 2^33 in a digit, before digits may overflow.
  static constexpr std::int64_t kMostTerms = std::int64_t{1} << 29;

  /// Brings all digits but the last one into 0..2^32 - 1.
  void carry() {
    for (std::size_t k = 0; k + 1 < kDigits; ++k) {
      const std::int64_t over = digits_[k] >> kDigitBits;  // rounded down
      digits_[k] -= over * (std::int64_t{1} << kDigitBits);
      digits_[k + 1] += over;
    }
    since_carry_ = 0;
  }

  std::array<std::int64_t, kDigits> digits_{};  ///< of 2^32k - 1074
  std::int64_t since_carry_ = 0;
};

}  // namespace ccvt
