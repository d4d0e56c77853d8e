#include "kernels/bounds.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bounds.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/highway.h>

#include <cmath>
#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr double kRounding = 1e-15;
constexpr double kWithin = 1e-14;

void bounds_changed(const float* dot, const double* shift, const double* length, Index count,
                    const BoundChange& change, double* bound) {
  const hn::ScalableTag<double> wide;
  const hn::Rebind<float, decltype(wide)> narrow;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  const auto scale = hn::Set(wide, change.scale);
  const auto reach = hn::Set(wide, change.reach);
  const auto growth = hn::Set(wide, change.growth);
  const auto rounding = hn::Set(wide, -kRounding);
  Index k = 0;
  for (; k + lanes <= count; k += lanes) {
    const auto before = hn::LoadU(wide, bound + k);
    const auto moved = hn::LoadU(wide, shift + k);
    const auto across = hn::Mul(scale, hn::PromoteTo(wide, hn::LoadU(narrow, dot + k)));
    const auto fall = hn::Add(hn::Mul(reach, hn::LoadU(wide, length + k)), growth);
    const auto terms =
        hn::Add(hn::Add(hn::Abs(before), hn::Abs(moved)), hn::Add(hn::Abs(across), hn::Abs(fall)));
    const auto after = hn::Sub(hn::Add(before, hn::Add(moved, across)), fall);
    hn::StoreU(hn::MulAdd(rounding, terms, after), wide, bound + k);
  }
  for (; k < count; ++k) {
    const double across = change.scale * double{dot[k]};
    const double fall = change.reach * length[k] + change.growth;
    const double terms =
        std::abs(bound[k]) + std::abs(shift[k]) + std::abs(across) + std::abs(fall);
    bound[k] = bound[k] + (shift[k] + across) - fall - kRounding * terms;
  }
}

bool is_within(double bound, double weight, double own) {
  const double rounding = kWithin * (std::abs(own) + std::abs(weight) + std::abs(bound));
  return !(bound + (own - weight) > rounding);
}

Index places_of_bounds(const double* bound, const double* weight, double own, Index count,
                       Index* places) {
  const hn::ScalableTag<double> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  const auto here = hn::Set(wide, own);
  const auto within = hn::Set(wide, kWithin);
  Index found = 0;
  Index k = 0;
  for (; k + lanes <= count; k += lanes) {
    const auto b = hn::LoadU(wide, bound + k);
    const auto w = hn::LoadU(wide, weight + k);
    const auto rounding = hn::Mul(within, hn::Add(hn::Add(hn::Abs(here), hn::Abs(w)), hn::Abs(b)));
    if (hn::AllTrue(wide, hn::Gt(hn::Add(b, hn::Sub(here, w)), rounding))) continue;
    for (Index l = k; l < k + lanes; ++l) {
      places[found] = l;
      found += is_within(bound[l], weight[l], own) ? 1 : 0;
    }
  }
  for (; k < count; ++k) {
    if (is_within(bound[k], weight[k], own)) places[found++] = k;
  }
  return found;
}

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

HWY_EXPORT(bounds_changed);
HWY_EXPORT(places_of_bounds);

void change_bounds(const float* dot, const double* shift, const double* length, Index count,
                   const BoundChange& change, double* bound) {
  HWY_DYNAMIC_DISPATCH(bounds_changed)(dot, shift, length, count, change, bound);
}

Index bounds_within(const double* bound, const double* weight, double own, Index count,
                    Index* places) {
  return HWY_DYNAMIC_DISPATCH(places_of_bounds)(bound, weight, own, count, places);
}

}  // namespace ccvt::kernels
#endif
