#include "support/plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "cli/chart.h"
#include "number_text.h"

namespace ccvt::bench {
namespace {

using cli::escaped;

constexpr double kNumbers = 66;  ///< room for numbers to the left
constexpr double kNames = 170;   ///< for names
constexpr double kRight = 16;
constexpr double kTop = 32;
constexpr double kBelow = 50;
constexpr double kLegendLine = 20;
constexpr std::size_t kColours = 8;

std::string number(double value) { return decimal_text(value, 2); }

/// What stands at a tick: plain where that is short, else as a power of ten.
std::string tick_text(double value) {
  if (value != 0 && (std::abs(value) >= 1e5 || std::abs(value) < 1e-3)) {
    const double power = std::floor(std::log10(std::abs(value)) + 1e-9);
    const std::string digits = decimal_text(value / std::pow(10, power), 3);
    return (digits == "1" ? "" : digits + "\xC2\xB7") + "10^" + decimal_text(power, 0);
  }
  return decimal_text(value, 4);
}

std::vector<double> ticks_of(const Axis& axis) {
  std::vector<double> ticks;
  if (!axis.logarithmic) {
    const double span = axis.most - axis.least;
    const double power = std::pow(10, std::floor(std::log10(span / 4)));
    const double share = span / 4 / power;
    const double step = power * (share >= 5 ? 5 : share >= 2 ? 2 : 1);
    for (double k = std::ceil(axis.least / step - 1e-9); k * step <= axis.most + 1e-9 * step; ++k) {
      ticks.push_back(k * step);
    }
    return ticks;
  }
  // Powers of ten; between them 2 and 5 where there are few.
  const double decades = std::log10(axis.most / axis.least);
  for (double p = std::floor(std::log10(axis.least)); p <= std::log10(axis.most); ++p) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10, p);
      if (decades > 3 && digit != 1) continue;
      if (value >= axis.least * (1 - 1e-9) && value <= axis.most * (1 + 1e-9)) {
        ticks.push_back(value);
      }
    }
  }
  return ticks;
}

double share_of(const Axis& axis, double value) {
  const double share = axis.logarithmic
                           ? std::log(value / axis.least) / std::log(axis.most / axis.least)
                           : (value - axis.least) / (axis.most - axis.least);
  return std::clamp(share, 0.0, 1.0);
}

class Drawing {
 public:
  Drawing(const Plot& plot, double width, double height)
      : plot_(plot), width_(width), height_(height), left_(plot.names.empty() ? kNumbers : kNames) {
    const double legend =
        plot.legend ? 8 + kLegendLine * static_cast<double>(plot.series.size()) : 0;
    bottom_ = height - kBelow - legend;
  }

  std::string draw() {
    svg_ = "<svg class=\"ccvt\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " +
           number(width_) + " " + number(height_) + "\" width=\"" + number(width_) +
           "\" height=\"" + number(height_) + "\" role=\"img\"><title>" + escaped(plot_.title) +
           "</title>\n";
    text((left_ + width_ - kRight) / 2, 20, "middle", plot_.title);
    axes();
    for (std::size_t s = 0; s < plot_.series.size(); ++s) {
      const std::string colour = " c" + std::to_string(s % kColours);
      if (plot_.bars && s == 0) {
        bars(plot_.series[s], colour);
      } else {
        curve(plot_.series[s], colour);
      }
      if (!plot_.legend) continue;
      const double y = bottom_ + kBelow + kLegendLine * static_cast<double>(s) + 4;
      line("curve" + colour, left_, y, left_ + 26, y);
      text(left_ + 34, y + 5, "start", plot_.series[s].name);
    }
    return svg_ + "</svg>\n";
  }

 private:
  [[nodiscard]] double at_x(double x) const {
    return left_ + (width_ - left_ - kRight) * share_of(plot_.x, x);
  }
  [[nodiscard]] double at_y(double y) const {
    const double share = share_of(plot_.y, y);
    return bottom_ - (bottom_ - kTop) * (plot_.names.empty() ? share : 1 - share);
  }
  void line(const std::string& style, double x0, double y0, double x1, double y1) {
    svg_ += "<line class=\"" + style + "\" x1=\"" + number(x0) + "\" y1=\"" + number(y0) +
            "\" x2=\"" + number(x1) + "\" y2=\"" + number(y1) + "\"/>\n";
  }
  void text(double x, double y, const std::string& anchor, const std::string& words,
            const std::string& more = "") {
    svg_ += "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\"" +
            more + ">" + escaped(words) + "</text>\n";
  }

  void axes() {
    for (const double x : ticks_of(plot_.x)) {
      line("grid", at_x(x), kTop, at_x(x), bottom_);
      text(at_x(x), bottom_ + 17, "middle", tick_text(x));
    }
    for (std::size_t k = 0; k < plot_.names.size(); ++k) {
      const double y = at_y(static_cast<double>(k));
      line("grid", left_, y, width_ - kRight, y);
      text(left_ - 10, y + 5, "end", plot_.names[k]);
    }
    for (const double y : plot_.names.empty() ? ticks_of(plot_.y) : std::vector<double>()) {
      line("grid", left_, at_y(y), width_ - kRight, at_y(y));
      text(left_ - 6, at_y(y) + 5, "end", tick_text(y));
    }
    text((left_ + width_ - kRight) / 2, bottom_ + 37, "middle", plot_.x.label);
    const double middle = (kTop + bottom_) / 2;
    text(15, middle, "middle", plot_.y.label,
         " transform=\"rotate(-90 15 " + number(middle) + ")\"");
  }

  void curve(const Series& series, const std::string& colour) {
    std::string path;
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      if (!std::isfinite(series.y[k])) continue;
      const std::string place = number(at_x(series.x[k])) + " " + number(at_y(series.y[k]));
      // Named places are no scale: nothing lies between two of them.
      if (plot_.names.empty()) path += (path.empty() ? "M" : "L") + place;
      if (plot_.marks) {
        svg_ += "<path class=\"curve" + colour + "\" style=\"stroke-width:7\" d=\"M" + place +
                "h0\"/>\n";
      }
    }
    if (!path.empty()) svg_ += "<path class=\"curve" + colour + "\" d=\"" + path + "\"/>\n";
  }

  void bars(const Series& series, const std::string& colour) {
    const double step = series.x.size() > 1 ? series.x[1] - series.x[0] : 1;
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      if (!(series.y[k] > plot_.y.least)) continue;
      const double left = at_x(series.x[k] - step / 2);
      const double right = at_x(series.x[k] + step / 2);
      const double top = at_y(series.y[k]);
      svg_ += "<path class=\"curve" + colour + "\" style=\"fill:#0b62a8;fill-opacity:.25\" d=\"M" +
              number(left) + " " + number(bottom_) + "V" + number(top) + "H" + number(right) + "V" +
              number(bottom_) + "Z\"/>\n";
    }
  }

  const Plot& plot_;
  double width_;
  double height_;
  double left_;
  double bottom_ = 0;
  std::string svg_;
};

}  // namespace

Axis axis_for(const std::string& label, const std::vector<std::vector<double>>& values,
              bool logarithmic) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const auto& list : values) {
    for (const double v : list) {
      if (!std::isfinite(v)) continue;
      least = std::min(least, v);
      most = std::max(most, v);
    }
  }
  if (!(least <= most)) throw std::invalid_argument(label + ": there is nothing to plot");
  if (!logarithmic) return {label, std::min(least, 0.0), most > 0 ? most * 1.05 : 1, false};
  if (!(least > 0))
    throw std::invalid_argument(label + ": a logarithmic axis of " + tick_text(least));
  return {label, least / 1.15, most * 1.15, true};
}

std::string draw(const Plot& plot, double width, double height) {
  return Drawing(plot, width, height).draw();
}

}  // namespace ccvt::bench
