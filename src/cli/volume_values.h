#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "ccvt/volume.h"
#include "cli/values.h"

namespace ccvt::cli {

// Each parses a value of the volume command, and returns what is wrong with it, or nothing.

/// "linear", "window:LO,HI", "threshold:T" or "gamma:G".
std::string parse_map(const std::string& text, ValueMap& map);

/// "uint16", or "uint16be" when the most significant byte comes first.
std::string parse_voxel_type(const std::string& text, VolumeLayout& layout);

/// "constant" or "linear".
std::string parse_interpolation(const std::string& text, Interpolation& interpolation);

/// `count` numbers with commas between them; 0: as many as there are.
template <class Number>
std::string parse_list(const std::string& text, std::size_t count, const Range<Number>& range,
                       std::vector<Number>& values) {
  values.clear();
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string field = text.substr(begin, end - begin);
    std::string wrong = field.empty() ? "'" + text + "' has an empty entry"
                                      : parse_number(field, range, values.emplace_back());
    if (!wrong.empty()) return wrong;
    begin = end + 1;
  }
  if (count == 0 || values.size() == count) return {};
  return "'" + text + "' has " + std::to_string(values.size()) + " numbers; needs " +
         std::to_string(count) + ", with commas between them";
}

}  // namespace ccvt::cli
