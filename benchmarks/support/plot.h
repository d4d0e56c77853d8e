#pragma once

#include <string>
#include <vector>

namespace ccvt::bench {

struct Series {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
};

/// An axis from `least` to `most`.
struct Axis {
  std::string label;
  double least = 0;
  double most = 1;
  bool logarithmic = false;  ///< needs 0 < least
};

/// The axis that holds all values; a linear one starts at 0. Throws std::invalid_argument when
/// there are none, or when they are not positive and the axis is logarithmic.
Axis axis_for(const std::string& label, const std::vector<std::vector<double>>& values,
              bool logarithmic);

struct Plot {
  std::string title;
  Axis x;
  Axis y;
  std::vector<Series> series;
  bool marks = true;  ///< a dot at each point
  bool bars = false;  ///< of the first series, as wide as the space between its x
  bool legend = true;
  /// Of the places 0, 1, ... on the y axis, top to bottom, in the place of its numbers.
  std::vector<std::string> names = {};
};

/// The plot as an <svg> element of `width` by `height`, its legend included. Parts of series beyond
/// the axes are drawn at their ends.
std::string draw(const Plot& plot, double width = 520, double height = 360);

}  // namespace ccvt::bench
