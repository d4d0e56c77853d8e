#pragma once

#include <string>
#include <vector>

namespace ccvt::cli {

/// A curve; points that are not finite leave a gap.
struct Curve {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
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
  double x_most = 1;  ///< x starts at 0
  double y_least = 0;
  double y_most = 1;
  std::vector<Curve> curves;
  std::vector<Guide> guides;
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
