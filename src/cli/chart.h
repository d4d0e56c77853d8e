#pragma once

#include <string>
#include <vector>

namespace ccvt::cli {

/// A curve; points that are not finite leave a gap.
struct Curve {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  int colour = -1;  ///< a number from 0; -1: that of the curve among all
  bool dashed = false;
};

/// A horizontal line that says what a curve may be compared with.
struct Guide {
  double y = 0;
  std::string name;
};

struct Chart {
  std::string title;
  std::string x_label;
  std::string y_label;
  double x_least = 0;
  double x_most = 1;
  double y_least = 0;
  double y_most = 1;
  std::vector<Curve> curves;
  std::vector<Guide> guides;
  /// Both axes; then all bounds are above 0, and what is not above 0 of a curve leaves a gap.
  bool logarithmic = false;
};

/// The chart as an <svg> element, to stand in a page that has svg_style(). Curves after the first
/// eight repeat colours.
std::string draw(const Chart& chart);

/// The colours of charts and drawings, in light and dark.
std::string svg_style();

/// An <svg> element as a file of its own.
std::string svg_file(const std::string& element);

/// `text` for use in XML and HTML.
std::string escaped(const std::string& text);

}  // namespace ccvt::cli
