#include "cli/chart.h"

#include <algorithm>
#include <cmath>

#include "number_text.h"

namespace ccvt::cli {

namespace {

constexpr double kWidth = 480;
constexpr double kLeft = 58;
constexpr double kRight = 14;
constexpr double kTop = 14;
constexpr double kPlotHeight = 240;
constexpr double kLegendLine = 20;
constexpr std::size_t kColours = 8;

/// 1, 2 or 5 times a power of ten, so that `span` has 4 to 10 of them.
double tick_step(double span) {
  const double power = std::pow(10, std::floor(std::log10(span / 4)));
  const double share = span / 4 / power;
  return power * (share >= 5 ? 5 : share >= 2 ? 2 : 1);
}

/// "0.05"; of less than a hundredth "10" and a raised "-7", in UTF-8. `value` has one digit.
std::string decade_text(double value) {
  if (value > 0.999e-2) return decimal_text(value, 3);
  const char* const raised[] = {"\xE2\x81\xB0", "\xC2\xB9",     "\xC2\xB2",     "\xC2\xB3",
                                "\xE2\x81\xB4", "\xE2\x81\xB5", "\xE2\x81\xB6", "\xE2\x81\xB7",
                                "\xE2\x81\xB8", "\xE2\x81\xB9"};
  const double power = std::floor(std::log10(value) + 1e-9);
  const double digit = std::round(value / std::pow(10, power));
  std::string label = (digit > 1 ? decimal_text(digit, 0) + "\xC2\xB7" : "") + "10\xE2\x81\xBB";
  for (const char c : decimal_text(-power, 0)) label += raised[c - '0'];
  return label;
}

/// Where the lines of a logarithmic axis are: 1, 2 and 5 times powers of ten where there are few
/// powers, else powers alone, as many as have room.
std::vector<double> logarithmic_ticks(double least, double most) {
  std::vector<double> ticks;
  const double decades = std::log10(most / least);
  const int step = std::max(1, static_cast<int>(std::ceil(decades / 10)));
  const int first = static_cast<int>(std::floor(std::log10(least) + 1e-9));
  for (int power = first; std::pow(10, power) <= most * (1 + 1e-9); power += step) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double tick = digit * std::pow(10, power);
      if (digit > 1 && decades > 3) break;
      if (tick >= least * (1 - 1e-9) && tick <= most * (1 + 1e-9)) ticks.push_back(tick);
    }
  }
  return ticks;
}

class Drawing {
 public:
  explicit Drawing(const Chart& chart) : chart_(chart) {
    const auto legend = static_cast<double>(chart.curves.size() + chart.guides.size());
    height_ = kTop + kPlotHeight + 48 + kLegendLine * legend;
  }

  std::string draw() {
    svg_ = R"(<svg class="ccvt" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 )" +
           number(kWidth) + " " + number(height_) + R"(" role="img"><title>)" +
           escaped(chart_.title) + "</title>\n";
    axes();
    double y = kTop + kPlotHeight + 62;
    for (const Guide& guide : chart_.guides) {
      if (guide.y >= chart_.y_least && guide.y <= chart_.y_most) {
        line("guide", kLeft, at_y(guide.y), kWidth - kRight, at_y(guide.y));
      }
    }
    for (std::size_t c = 0; c < chart_.curves.size(); ++c) {
      const int colour = chart_.curves[c].colour;
      const std::size_t number = colour < 0 ? c : static_cast<std::size_t>(colour);
      const std::string style = "curve c" + std::to_string(number % kColours) +
                                (chart_.curves[c].dashed ? " dashed" : "");
      curve(chart_.curves[c], style);
      legend(style, chart_.curves[c].name, y);
    }
    for (const Guide& guide : chart_.guides) legend("guide", guide.name, y);
    return svg_ + "</svg>\n";
  }

 private:
  static std::string number(double value) { return decimal_text(value, 2); }
  /// How far `value` is from one bound to the other.
  [[nodiscard]] double share(double value, double least, double most) const {
    if (chart_.logarithmic) return std::log(value / least) / std::log(most / least);
    return (value - least) / (most - least);
  }
  [[nodiscard]] double at_x(double x) const {
    return kLeft + (kWidth - kLeft - kRight) * share(x, chart_.x_least, chart_.x_most);
  }
  [[nodiscard]] double at_y(double y) const {
    return kTop + kPlotHeight * (1 - share(y, chart_.y_least, chart_.y_most));
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

  [[nodiscard]] std::vector<double> ticks(double least, double most) const {
    if (chart_.logarithmic) return logarithmic_ticks(least, most);
    std::vector<double> ticks;
    const double step = tick_step(most - least);
    const double first = std::ceil(least / step - 1e-9);
    for (int i = 0; (first + i) * step <= most + 1e-9 * step; ++i)
      ticks.push_back((first + i) * step);
    return ticks;
  }
  [[nodiscard]] std::string tick_text(double value) const {
    return chart_.logarithmic ? decade_text(value) : decimal_text(value, 3);
  }

  void axes() {
    const double bottom = kTop + kPlotHeight;
    for (const double x : ticks(chart_.x_least, chart_.x_most)) {
      line("grid", at_x(x), kTop, at_x(x), bottom);
      text(at_x(x), bottom + 18, "middle", tick_text(x));
    }
    for (const double y : ticks(chart_.y_least, chart_.y_most)) {
      line("grid", kLeft, at_y(y), kWidth - kRight, at_y(y));
      text(kLeft - 6, at_y(y) + 5, "end", tick_text(y));
    }
    text((kLeft + kWidth - kRight) / 2, bottom + 40, "middle", chart_.x_label);
    const std::string middle = number(kTop + kPlotHeight / 2);
    text(14, kTop + kPlotHeight / 2, "middle", chart_.y_label,
         " transform=\"rotate(-90 14 " + middle + ")\"");
  }

  void curve(const Curve& curve, const std::string& style) {
    std::string path;
    bool pen_down = false;
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (!std::isfinite(curve.y[i]) || (chart_.logarithmic && !(curve.y[i] > 0))) {
        pen_down = false;
        continue;
      }
      const double y = std::clamp(curve.y[i], chart_.y_least, chart_.y_most);
      path += (pen_down ? "L" : "M") + number(at_x(curve.x[i])) + " " + number(at_y(y));
      // A lone point is drawn as a dot, by the round ends of its line.
      if (!pen_down) path += "h0";
      pen_down = true;
    }
    if (!path.empty()) svg_ += "<path class=\"" + style + "\" d=\"" + path + "\"/>\n";
  }

  void legend(const std::string& style, const std::string& name, double& y) {
    line(style, kLeft, y - 5, kLeft + 28, y - 5);
    text(kLeft + 36, y, "start", name);
    y += kLegendLine;
  }

  const Chart& chart_;
  double height_ = 0;
  std::string svg_;
};

}  // namespace

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return result;
}

std::string draw(const Chart& chart) { return Drawing(chart).draw(); }

std::string svg_style() {
  std::string light;
  std::string dark;
  const char* const light_colours[kColours] = {"#0b62a8", "#c2410c", "#15803d", "#7e22ce",
                                               "#a16207", "#be185d", "#0e7490", "#52525b"};
  const char* const dark_colours[kColours] = {"#60a5fa", "#fb923c", "#4ade80", "#c084fc",
                                              "#facc15", "#f472b6", "#22d3ee", "#a1a1aa"};
  for (std::size_t c = 0; c < kColours; ++c) {
    const std::string selector = ".ccvt .c" + std::to_string(c);
    light += selector + "{stroke:" + light_colours[c] + "}\n";
    dark += selector + "{stroke:" + dark_colours[c] + "}\n";
  }
  return ".ccvt text{font:14px system-ui,sans-serif;fill:#27272a}\n"
         ".ccvt .paper{fill:#fff}\n"
         ".ccvt .grid{stroke:#e4e4e7}\n"
         ".ccvt .guide{stroke:#71717a;stroke-width:1.5;stroke-dasharray:5 4}\n"
         ".ccvt .curve{fill:none;stroke-width:2;stroke-linejoin:round;stroke-linecap:round}\n"
         ".ccvt .dashed{stroke-dasharray:3 5}\n"
         ".ccvt .box{fill:none;stroke:#a1a1aa}\n"
         ".ccvt .dots{fill:#18181b}\n" +
         light +
         "@media (prefers-color-scheme:dark){\n"
         ".ccvt text{fill:#e4e4e7}\n"
         ".ccvt .paper{fill:#18181b}\n"
         ".ccvt .grid{stroke:#3f3f46}\n"
         ".ccvt .guide{stroke:#a1a1aa}\n"
         ".ccvt .box{stroke:#71717a}\n"
         ".ccvt .dots{fill:#f4f4f5}\n" +
         dark + "}\n";
}

std::string svg_file(const std::string& element) {
  std::string file = element;
  const auto start = file.find('>') + 1;
  file.insert(start, "\n<style>\n" + svg_style() +
                         "</style>\n<rect class=\"paper\" width=\"100%\" height=\"100%\"/>");
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + file;
}

}  // namespace ccvt::cli
