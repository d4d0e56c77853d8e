#pragma once

#include <cstddef>
#include <vector>

namespace ccvt {

/// Sorts `items` by key(item) < keys; those of one key keep their order. O(items + keys).
template <class Item, class Key>
void counting_sort(std::vector<Item>& items, std::size_t keys, Key key) {
  std::vector<std::size_t> next(keys + 1, 0);
  for (const Item& item : items) ++next[static_cast<std::size_t>(key(item)) + 1];
  for (std::size_t k = 0; k < keys; ++k) next[k + 1] += next[k];
  std::vector<Item> sorted(items.size());
  for (const Item& item : items) sorted[next[static_cast<std::size_t>(key(item))]++] = item;
  items.swap(sorted);
}

}  // namespace ccvt
