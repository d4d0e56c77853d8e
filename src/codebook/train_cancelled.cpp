// How a training that was cancelled ends.
#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "codebook/dealing.h"
#include "codebook/trainer.h"
#include "exact/assignment.h"
#include "numbers.h"

namespace ccvt {
namespace {

/// To give vectors codewords when training was cancelled before that, or to tell how good they are.
constexpr std::chrono::milliseconds kTimeToDeal{2000};

}  // namespace

/// With the last owners that met the capacities, and how good they are if there is time for that;
/// what to warn of.
template <class Scalar>
std::string Trainer<Scalar>::settle_for_met() {
  owners_ = std::move(met_.owners);
  weights_ = std::move(met_.weights);
  summary_.gap = 1;
  std::string warning =
      "training ended before a last exact assignment: codes keep the capacities, but may cost more "
      "than they need to";
  try {
    summary_.gap = exact_assignment().certify(sites_, weights_, owners_).share();
    warning += ", by the gap at most";
  } catch (const Stopped&) {
  }
  return warning;
}

/// Lloyd's, with the nearest codewords. What to warn of.
template <class Scalar>
std::string Trainer<Scalar>::settle_for_nearest() {
  const bool owned = owned_ == source_.count();
  owned_ = 0;
  try {
    own_nearest(source_);
  } catch (const Stopped&) {
    if (!owned) return deal_in_order();
    return "training ended before vectors had the codes of their nearest codewords: some have "
           "those of codewords that were nearest before";
  }
  return "";
}

template <class Scalar>
std::string Trainer<Scalar>::deal_in_order() {
  owners_.clear();
  for (const SiteNumber s : sites_below(problem_.site_count())) {
    owners_.insert(owners_.end(), static_cast<std::size_t>(problem_.capacities()[s]), s.index());
  }
  return "training ended before vectors had codewords: they were dealt out in their order";
}

/// With vectors dealt to the nearest codewords that have room. Where that would take too long they
/// are dealt out in their order. What to warn of.
template <class Scalar>
std::string Trainer<Scalar>::settle_for_near() {
  const bool exact = options_.method == CodebookMethod::exact;
  if (exact) {
    summary_.gap = 1;
    std::fill(weights_.begin(), weights_.end(), 0.0);
  }
  try {
    owners_ = deal_to_nearest(vectors_, sites_, problem_.capacities(), arena_);
  } catch (const Stopped&) {
    return deal_in_order();
  }
  if (!exact) return "";
  return "training ended before an exact assignment: codes keep the capacities, but may cost far "
         "more than they need to, and weights are 0";
}

/// Ends a cancelled run without a last exact assignment. Not of several ranks, whose last one takes
/// the time that it takes.
template <class Scalar>
void Trainer<Scalar>::settle_for_less() {
  summary_.termination = Termination::cancelled;
  stop_.allow(kTimeToDeal);
  std::string warning;
  if (options_.method == CodebookMethod::lloyd) {
    warning = settle_for_nearest();
  } else {
    warning = met_.owners.empty() ? settle_for_near() : settle_for_met();
  }
  if (!warning.empty()) summary_.warnings.push_back(warning);
  stop_.off();
}

/// Ends with an exact assignment if there is time for it.
template <class Scalar>
void Trainer<Scalar>::end_cancelled() {
  if (options_.method != CodebookMethod::exact) return settle_for_less();
  if (problem_.ranks() == nullptr) stop_.allow(time_to_finish_);  // ranks would not end alike
  try {
    own_nearest(source_);
    prove();
  } catch (const Stopped&) {
    return settle_for_less();
  }
  stop_.off();
  summary_.termination = Termination::cancelled;
}

template void Trainer<float>::end_cancelled();
template void Trainer<double>::end_cancelled();

}  // namespace ccvt
