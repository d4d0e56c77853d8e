#include "cli/volume_values.h"

#include <limits>

namespace ccvt::cli {

std::string parse_map(const std::string& text, ValueMap& map) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  std::vector<double> numbers;
  std::string wrong;
  if (name == "linear" && colon == std::string::npos) {
    map.kind = ValueMap::Kind::linear;
    return {};
  }
  if (name == "window") {
    map.kind = ValueMap::Kind::window;
    wrong = parse_list(rest, 2, Range<double>{}, numbers);
    if (!wrong.empty()) return "window:LO,HI: " + wrong;
    if (!(numbers[0] < numbers[1])) {
      return "'" + text + "' is not window:LO,HI with LO less than HI";
    }
    map.low = numbers[0];
    map.high = numbers[1];
    return {};
  }
  if (name == "threshold") {
    map.kind = ValueMap::Kind::threshold;
    wrong = parse_list(rest, 1, Range<double>{}, numbers);
    if (!wrong.empty()) return "threshold:T: " + wrong;
    map.low = numbers[0];
    return {};
  }
  if (name == "gamma") {
    map.kind = ValueMap::Kind::gamma;
    const Range<double> positive{
        .least = 0, .most = std::numeric_limits<double>::max(), .open_below = true};
    wrong = parse_list(rest, 1, positive, numbers);
    if (!wrong.empty()) return "gamma:G: " + wrong;
    map.gamma = numbers[0];
    return {};
  }
  return "'" + text + "' is not one of linear, window:LO,HI, threshold:T, gamma:G";
}

std::string parse_interpolation(const std::string& text, Interpolation& interpolation) {
  if (text != "constant" && text != "linear") {
    return "'" + text + "' is not one of constant, linear";
  }
  interpolation = text == "linear" ? Interpolation::linear : Interpolation::constant;
  return {};
}

std::string parse_voxel_type(const std::string& text, VolumeLayout& layout) {
  const bool big = text.size() > 2 && text.substr(text.size() - 2) == "be";
  const std::string name = big ? text.substr(0, text.size() - 2) : text;
  for (int i = 0; i <= static_cast<int>(VoxelType::float64); ++i) {
    const auto type = static_cast<VoxelType>(i);
    if (name != to_string(type)) continue;
    layout.type = type;
    layout.big_endian = big;
    return {};
  }
  return "'" + text +
         "' is not one of int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, "
         "float64, or one of these followed by be";
}

}  // namespace ccvt::cli
