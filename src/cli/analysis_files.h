#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/metrics.h"

namespace ccvt::cli {

/// The runs of one kind of point set, and what they came to.
struct AnalyzedSet {
  std::string name;
  std::vector<std::string> files;
  std::vector<PointSet> runs;
  Analysis analysis;
};

/// The figures that tables show, each with the words for it.
struct Figure {
  const char* key;   ///< in metrics.json
  const char* name;  ///< in tables
  const char* what;  ///< what it means
  double value;
};
std::vector<Figure> figures_of(const Analysis& analysis);

/// All figures and curves of one set.
nlohmann::ordered_json metrics_of(const AnalyzedSet& set);

/// frequency,power,anisotropy_db: a line a ring.
std::string radial_csv(const Analysis& analysis);

/// frequency,frequencies,power,fit: a line a shell at low frequency.
std::string low_frequency_csv(const Analysis& analysis);

/// Power over frequency on logarithmic axes, shells at low frequency and rings from there on, and
/// the fitted lines.
std::string power_law_svg(const std::vector<AnalyzedSet>& sets);
std::string radial_svg(const std::vector<AnalyzedSet>& sets);
std::string anisotropy_svg(const std::vector<AnalyzedSet>& sets);
std::string pair_correlation_svg(const std::vector<AnalyzedSet>& sets);

/// The spectrum, grey P / (1 + P): black is no power, the middle is white noise. In 3D the central
/// planes xy, xz and yz; in more dimensions that of the first two.
Image spectrum_image(const AnalyzedSet& set, int threads);
std::string spectrum_caption(const AnalyzedSet& set);

struct PointsPicture {
  std::string svg;
  std::string caption;
};
/// The first run; in 3D a slice of it, in more dimensions the first two coordinates; of too many a
/// window.
PointsPicture points_picture(const AnalyzedSet& set);

}  // namespace ccvt::cli
