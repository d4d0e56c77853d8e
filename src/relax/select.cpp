#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>

#include "relax/swap.h"

namespace ccvt {
namespace {

/// Of one cell: so few candidates are sorted sooner than a median is found.
constexpr std::size_t kFew = 8;

bool more_to_j(const Candidate& a, const Candidate& b) {
  return a.key != b.key ? a.key > b.key : a.place < b.place;
}
bool more_to_i(const Candidate& a, const Candidate& b) {
  return a.key != b.key ? a.key < b.key : a.place < b.place;
}

/// Cuts both lists, best candidates first, where an exchange no longer gains.
void keep_gaining(double margin, Exchange& moves) {
  std::size_t k = 0;
  const std::size_t limit = std::min(moves.from_i.size(), moves.from_j.size());
  while (k < limit && moves.from_i[k].key - moves.from_j[k].key > margin) ++k;
  moves.from_i.resize(k);
  moves.from_j.resize(k);
}

void sort_swap(double margin, Exchange& moves) {
  std::sort(moves.from_i.begin(), moves.from_i.end(), more_to_j);
  std::sort(moves.from_j.begin(), moves.from_j.end(), more_to_i);
  keep_gaining(margin, moves);
}

/// The same, where one cell has few candidates: no more of the other's need be in order.
void sort_few(double margin, Exchange& moves) {
  auto& i = moves.from_i;
  auto& j = moves.from_j;
  const std::ptrdiff_t most = std::min(std::ssize(i), std::ssize(j));
  std::partial_sort(i.begin(), i.begin() + most, i.end(), more_to_j);
  std::partial_sort(j.begin(), j.begin() + most, j.end(), more_to_i);
  keep_gaining(margin, moves);
}

void heap_swap(double margin, Exchange& moves) {
  // The heaps' tops, once popped, gather at the ends of the lists, the best last.
  const auto less_to_j = [](const Candidate& a, const Candidate& b) { return more_to_j(b, a); };
  const auto less_to_i = [](const Candidate& a, const Candidate& b) { return more_to_i(b, a); };
  auto& i = moves.from_i;
  auto& j = moves.from_j;
  // What the heaps' tops will be is known before there are heaps: most pairs exchange nothing.
  const auto top_i = std::max_element(i.begin(), i.end(), less_to_j);
  const auto top_j = std::max_element(j.begin(), j.end(), less_to_i);
  if (i.empty() || j.empty() || !(top_i->key - top_j->key > margin)) {
    i.clear();
    j.clear();
    return;
  }
  std::make_heap(i.begin(), i.end(), less_to_j);
  std::make_heap(j.begin(), j.end(), less_to_i);
  auto i_end = i.end();
  auto j_end = j.end();
  while (i_end != i.begin() && j_end != j.begin() && i.front().key - j.front().key > margin) {
    std::pop_heap(i.begin(), i_end--, less_to_j);
    std::pop_heap(j.begin(), j_end--, less_to_i);
  }
  i.erase(i.begin(), i_end);
  j.erase(j.begin(), j_end);
}

/// Cell i keeps as many of all candidates as it brought: those with the lowest keys. What it
/// brought and does not keep moves to j, and the other way round. Of equal keys those move that
/// sort_swap() would move.
void median_swap(double margin, Exchange& moves) {
  if (std::min(moves.from_i.size(), moves.from_j.size()) <= kFew) return sort_few(margin, moves);
  using Choice = Exchange::Choice;
  std::vector<Choice>& all = moves.both;
  all.clear();
  for (const Candidate& c : moves.from_i) all.push_back({c.key, c.place, false});
  for (const Candidate& c : moves.from_j) all.push_back({c.key, c.place, true});
  const std::span<Choice> kept_by_i = std::span(all).first(moves.from_i.size());
  const std::span<Choice> kept_by_j = std::span(all).subspan(moves.from_i.size());
  std::nth_element(all.data(), kept_by_j.data(), all.data() + all.size(),
                   [](const Choice& a, const Choice& b) {
                     if (a.key != b.key) return a.key < b.key;
                     if (a.from_j != b.from_j) return b.from_j;
                     return a.from_j ? a.place < b.place : a.place > b.place;
                   });
  moves.from_i.clear();
  moves.from_j.clear();
  for (const Choice& c : kept_by_i) {
    if (c.from_j) moves.from_j.push_back({c.key, c.place});
  }
  for (const Choice& c : kept_by_j) {
    if (!c.from_j) moves.from_i.push_back({c.key, c.place});
  }
  if (moves.from_i.empty()) return;
  const double weakest_i =
      std::min_element(moves.from_i.begin(), moves.from_i.end(), more_to_i)->key;
  const double weakest_j =
      std::min_element(moves.from_j.begin(), moves.from_j.end(), more_to_j)->key;
  if (weakest_i - weakest_j <= margin) sort_swap(margin, moves);
}

}  // namespace

void select_exchange(SwapMethod method, double margin, Exchange& candidates) {
  switch (method) {
    case SwapMethod::median:
      return median_swap(margin, candidates);
    case SwapMethod::heap:
      return heap_swap(margin, candidates);
    case SwapMethod::sort:
      return sort_swap(margin, candidates);
  }
}

}  // namespace ccvt
