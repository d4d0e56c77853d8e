#pragma once

#include <string>
#include <vector>

#include "cli/analysis_files.h"

namespace ccvt::cli {

/// One self-contained page: the figures of all sets side by side, the charts, and for each set its
/// spectrum and its points. `spectra`: the bytes of one PNG file a set.
std::string report_page(const std::vector<AnalyzedSet>& sets,
                        const std::vector<std::string>& spectra);

/// The figures of all sets side by side, for a terminal.
std::string report_table(const std::vector<AnalyzedSet>& sets);

/// "1024 points in 2D, 4 runs".
std::string describe(const AnalyzedSet& set);

}  // namespace ccvt::cli
