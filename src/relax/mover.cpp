#include "relax/mover.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "kernels/keys.h"

namespace ccvt {
namespace {

constexpr Index kColumns = 16;
constexpr Index kColumnsAChoice = 4;

}  // namespace

template <class Scalar>
Mover<Scalar>::Mover(const Metric& metric, const SiteState& sites, Filling<Scalar>& filling)
    : metric_(metric), sites_(sites), filling_(filling) {
  const std::size_t size = sites.dimension;
  middle_.resize(size);
  normal_.resize(size);
  moving_.resize(size);
  if (!metric.periodic()) return;
  extent_.assign(metric.extent(), metric.extent() + size);
  turn_.resize(size);
}

template <class Scalar>
void Mover<Scalar>::leave(SiteNumber from) {
  from_ = from;
  waiting_.clear();
  waiting_x_.clear();
  while (filling_.waiting(from) > 0) {
    const Scalar* x = nullptr;
    waiting_.push_back(filling_.take_waiting(from, x));
    waiting_x_.insert(waiting_x_.end(), x, x + normal_.size());
  }
}

template <class Scalar>
void Mover<Scalar>::stay() {
  for (std::size_t w = 0; w < waiting_.size(); ++w) {
    filling_.add(from_, waiting_[w], &waiting_x_[w * normal_.size()]);
  }
}

template <class Scalar>
Index Mover<Scalar>::move(SiteNumber to, Index count) {
  place_cut(from_, to);
  const Index filled = filling_.filled[from_];
  const auto waiting = static_cast<Index>(waiting_.size());
  if (waiting > std::numeric_limits<Index>::max() - filled) {
    throw std::length_error("balance: more points than can be numbered are in a cell and wait");
  }
  const Index places = filled + waiting;
  const Index moved = std::min(count, places);
  // A cell that is not full has the stride of a full one: keys of empty places are overwritten.
  const Index size = filling_.cells.size(from_);
  keys_.resize(static_cast<std::size_t>(std::max(places, size)));
  if (filled > 0) keys_of(filling_.cells.block(from_), size, keys_.data());
  as_block();
  keys_of(block_.data(), waiting, keys_.data() + filled);
  choose(moved, places);
  // From the last place to the first, so that filling a gap does not move a chosen point.
  std::sort(choices_.begin(), choices_.end(),
            [](const Choice& a, const Choice& b) { return a.place > b.place; });
  const std::ptrdiff_t dimension = metric_.dimension();
  for (const Choice& choice : choices_) {
    if (choice.place >= filled) {
      const Index w = choice.place - filled;
      PointOfAll& point = waiting_.begin()[w];
      Scalar* const x = waiting_x_.data() + w * dimension;
      filling_.add(to, point, x);
      point = waiting_.back();
      waiting_.pop_back();
      const auto last = waiting_x_.end() - dimension;
      std::copy(last, waiting_x_.end(), x);
      waiting_x_.erase(last, waiting_x_.end());
    } else {
      filling_.cells.get(from_, choice.place, moving_.data());
      filling_.add(to, filling_.take(from_, choice.place), moving_.data());
    }
  }
  return moved;
}

/// Chooses the best `wanted` of all places; of equal keys the first place is better. Places are
/// dealt out to columns: of the columns with the highest keys, as many as are wanted, the lowest
/// of these keys is one that no chosen place can be below, and few columns have a place above.
template <class Scalar>
void Mover<Scalar>::choose(Index wanted, Index places) {
  choices_.clear();
  if (wanted == 0) return;
  const Scalar* const keys = keys_.data();
  if (wanted > places / (2 * kColumnsAChoice)) {
    for (Index k = 0; k < places; ++k) {
      if (!std::isnan(keys[k])) choices_.push_back({keys[k], k});
    }
  } else {
    const Index columns = std::max(std::min(kColumns, places), kColumnsAChoice * wanted);
    // So that what is not a number is not among them.
    highest_.assign(static_cast<std::size_t>(columns), -std::numeric_limits<Scalar>::infinity());
    Scalar* const highest = highest_.data();
    const Index whole = places - places % columns;
    for (Index row = 0; row < whole; row += columns) {
      for (Index c = 0; c < columns; ++c) highest[c] = std::max(highest[c], keys[row + c]);
    }
    for (Index k = whole; k < places; ++k) {
      highest[k - whole] = std::max(highest[k - whole], keys[k]);
    }
    sorted_ = highest_;
    const auto last = sorted_.begin() + wanted - 1;
    std::nth_element(sorted_.begin(), last, sorted_.end(), std::greater<>());
    const Scalar floor = *last;
    for (Index c = 0; c < columns; ++c) {
      if (highest[c] < floor) continue;
      for (Index k = c; k < places; k += columns) {
        if (keys[k] >= floor) choices_.push_back({keys[k], k});
      }
    }
  }
  if (std::ssize(choices_) < wanted) throw std::logic_error("balance: a key is not a number");
  if (std::ssize(choices_) == wanted) return;
  const auto rest = choices_.begin() + wanted;
  std::nth_element(choices_.begin(), rest, choices_.end(), Better());
  choices_.erase(rest, choices_.end());
}

/// The points that wait, with a stream for each dimension.
template <class Scalar>
void Mover<Scalar>::as_block() {
  const std::size_t dimension = normal_.size();
  block_.resize(waiting_x_.size());
  for (std::size_t w = 0; w < waiting_.size(); ++w) {
    for (std::size_t d = 0; d < dimension; ++d) {
      block_[d * waiting_.size() + w] = waiting_x_[w * dimension + d];
    }
  }
}

template <class Scalar>
void Mover<Scalar>::place_cut(SiteNumber from, SiteNumber to) {
  const double* a = sites_.at(from);
  const double* b = sites_.at(to);
  for (std::size_t d = 0; d < middle_.size(); ++d) {
    const auto k = static_cast<int>(d);
    const double u = metric_.wrap(b[d] - a[d], k);
    double middle = a[d] + u / 2;
    if (metric_.periodic()) {
      const Metric::Unrolled frame = metric_.unrolled(middle, k);
      middle = frame.origin;
      turn_[d] = static_cast<Scalar>(frame.turn);
    }
    normal_[d] = static_cast<Scalar>(u);
    middle_[d] = static_cast<Scalar>(middle);
  }
}

template <class Scalar>
void Mover<Scalar>::keys_of(const Scalar* block, Index count, Scalar* keys) {
  const int dimension = metric_.dimension();
  if (metric_.periodic()) {
    kernels::keys(
        block, count, dimension,
        kernels::WrappedCut<Scalar>{middle_.data(), normal_.data(), turn_.data(), extent_.data()},
        keys);
  } else {
    kernels::keys(block, count, dimension, kernels::Cut<Scalar>{middle_.data(), normal_.data()},
                  keys);
  }
}

template class Mover<float>;
template class Mover<double>;

}  // namespace ccvt
