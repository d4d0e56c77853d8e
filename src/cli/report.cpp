#include "cli/report.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include "ccvt/version.h"
#include "cli/chart.h"
#include "cli/values.h"

namespace ccvt::cli {

namespace {

constexpr const char* kPageStyle = R"(
:root{color-scheme:light dark;--ink:#18181b;--soft:#52525b;--paper:#fafafa;--card:#fff;--edge:#e4e4e7}
@media (prefers-color-scheme:dark){
:root{--ink:#f4f4f5;--soft:#a1a1aa;--paper:#09090b;--card:#18181b;--edge:#3f3f46}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1280px;padding:16px;background:var(--paper);color:var(--ink);
font:16px/1.5 system-ui,sans-serif;overflow-wrap:anywhere}
h1{font-size:1.5rem;margin:.5rem 0}
h2{font-size:1.15rem;margin:0 0 .5rem}
p,figcaption,footer{color:var(--soft);font-size:.9rem;margin:.4rem 0}
section,.card{background:var(--card);border:1px solid var(--edge);border-radius:8px;
padding:14px;margin:0 0 16px}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,390px),1fr));gap:16px}
.grid .card{margin:0}
.grid{margin-bottom:16px}
figure{margin:0}
svg,img{display:block;width:100%;height:auto}
img{image-rendering:pixelated}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%}
th,td{padding:5px 8px;border-bottom:1px solid var(--edge);text-align:right;vertical-align:top}
tbody th{text-align:left;font-weight:400;overflow-wrap:normal}
thead th{color:var(--soft);font-weight:600}
td{font-variant-numeric:tabular-nums;white-space:nowrap}
@media (max-width:520px){th,td{padding:5px 3px;font-size:.85rem}section,.card{padding:10px}}
.files{font-size:.9rem;margin:.3rem 0;padding-left:1.2rem}
dt{font-weight:600}
dd{margin:0 0 .5rem;color:var(--soft)}
)";

constexpr const char* kNone = "n/a";
constexpr const char* kWhyNone =
    "the points have nothing to take the figure from: no frequency in that range, no cell inside "
    "the box, or another dimension";

std::string value_text(double value) {
  if (std::abs(value) < 1e-12) return "0";  // all that rounding leaves of it
  if (!std::isfinite(value)) return kNone;
  return text(value, 4);
}

std::string base64(const std::string& bytes) {
  static constexpr char letters[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? letters[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

/// The figures that at least one set has, in the order of the sets.
std::vector<Figure> rows_of(const std::vector<AnalyzedSet>& sets) {
  std::vector<Figure> rows;
  std::set<std::string> seen;
  for (const AnalyzedSet& set : sets) {
    for (const Figure& figure : figures_of(set.analysis)) {
      if (seen.insert(figure.key).second) rows.push_back(figure);
    }
  }
  return rows;
}

std::string value_of(const AnalyzedSet& set, const std::string& key) {
  for (const Figure& figure : figures_of(set.analysis)) {
    if (figure.key == key) return value_text(figure.value);
  }
  return value_text(NAN);
}

std::string table(const std::vector<AnalyzedSet>& sets) {
  std::string html = "<section><h2>Figures</h2><div class=\"scroll\"><table><thead><tr><th></th>";
  for (const AnalyzedSet& set : sets) html += "<th>" + escaped(set.name) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (const Figure& row : rows_of(sets)) {
    html += "<tr><th>" + escaped(row.name) + "</th>";
    for (const AnalyzedSet& set : sets) html += "<td>" + value_of(set, row.key) + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table></div></section>\n";
}

std::string figure_card(const std::string& title, const std::string& picture,
                        const std::string& caption) {
  return "<div class=\"card\"><h2>" + escaped(title) + "</h2><figure>\n" + picture +
         (caption.empty() ? "" : "<figcaption>" + escaped(caption) + "</figcaption>") +
         "</figure></div>\n";
}

std::string meanings(const std::vector<AnalyzedSet>& sets) {
  std::string html = "<section><h2>What the figures mean</h2><dl>\n";
  std::string before;
  for (const Figure& row : rows_of(sets)) {
    if (row.what == before) continue;  // the test functions share theirs
    before = row.what;
    const std::string name = row.name;
    html += "<dt>" + escaped(name.rfind("variance", 0) == 0 ? "variance" : name) + "</dt><dd>" +
            escaped(row.what) + ".</dd>\n";
  }
  html +=
      "<dt>radially averaged power</dt><dd>Mean of |sum over points of exp(-2\xCF\x80i f\xC2\xB7p)"
      "|\xC2\xB2 / n over rings of frequencies; 1 for white noise.</dd>\n"
      "<dt>anisotropy</dt><dd>Variance of the power in a ring over its squared mean; with k runs "
      "-10 log10(k) dB where there is no structure.</dd>\n"
      "<dt>pair correlation</dt><dd>How many pairs of points are at a distance, as a share of "
      "those of independent points.</dd>\n";
  html += std::string("<dt>") + kNone + "</dt><dd>" + escaped(kWhyNone) + ".</dd>\n";
  return html + "</dl></section>\n";
}

}  // namespace

std::string describe(const AnalyzedSet& set) {
  const Analysis& analysis = set.analysis;
  return std::to_string(analysis.points) + " points in " + std::to_string(analysis.dimension) +
         "D, " + (set.runs.front().domain().is_periodic() ? "periodic, " : "") +
         std::to_string(analysis.sets) + (analysis.sets == 1 ? " run" : " runs");
}

std::string report_table(const std::vector<AnalyzedSet>& sets) {
  std::vector<std::vector<std::string>> rows(1, {""});
  for (const AnalyzedSet& set : sets) rows[0].push_back(set.name);
  for (const Figure& figure : rows_of(sets)) {
    std::vector<std::string>& row = rows.emplace_back();
    row.emplace_back(figure.name);
    for (const AnalyzedSet& set : sets) row.push_back(value_of(set, figure.key));
  }
  std::vector<std::size_t> widths(sets.size() + 1, 0);
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  }
  std::string text;
  for (const AnalyzedSet& set : sets) text += set.name + ": " + describe(set) + "\n";
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string blanks(widths[c] - width_of(row[c]), ' ');
      text += c == 0 ? row[c] + blanks : "  " + blanks + row[c];
    }
    text += "\n";
  }
  const bool lacking = std::any_of(rows.begin() + 1, rows.end(), [](const auto& row) {
    return std::find(row.begin() + 1, row.end(), kNone) != row.end();
  });
  if (lacking) text += std::string(kNone) + ": " + kWhyNone + "\n";
  return text;
}

std::string report_page(const std::vector<AnalyzedSet>& sets,
                        const std::vector<std::string>& spectra) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
      "<title>Point sets</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>" +
      std::string(kPageStyle) + svg_style() + "</style></head><body>\n<h1>Point sets</h1>\n";
  html += "<ul class=\"files\">\n";
  for (const AnalyzedSet& set : sets) {
    html += "<li><b>" + escaped(set.name) + "</b>: " + escaped(describe(set)) + "</li>\n";
  }
  html += "</ul>\n" + table(sets);
  html += "<div class=\"grid\">\n";
  html += figure_card("Radially averaged power", radial_svg(sets), "");
  html += figure_card("Power on logarithmic axes", power_law_svg(sets),
                      "Dashed: the power law fitted at low frequency.");
  html += figure_card("Anisotropy", anisotropy_svg(sets), "");
  html += figure_card("Pair correlation", pair_correlation_svg(sets), "");
  html += "</div>\n";
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const AnalyzedSet& set = sets[s];
    const std::string whose = sets.size() > 1 ? " (" + set.name + ")" : "";
    html += "<div class=\"grid\">\n";
    html += figure_card("Spectrum" + whose,
                        "<img alt=\"" + escaped("Spectrum of " + set.name) +
                            "\" src=\"data:image/png;base64," + base64(spectra[s]) + "\">\n",
                        spectrum_caption(set));
    const PointsPicture points = points_picture(set);
    html += figure_card("Points" + whose, points.svg, points.caption);
    html += "</div>\n";
  }
  html += meanings(sets);
  return html + "<footer>ccvt " CCVT_VERSION "</footer>\n</body></html>\n";
}

}  // namespace ccvt::cli
