#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/child.h"

/// What the parts of the report share. Each part takes what an experiment wrote, writes its
/// pictures into `directory`, and returns its chapter in Markdown.
namespace ccvt::bench {

std::string report_table1(const Json& record, const std::filesystem::path& directory);
std::string report_clusters(const Json& record, const std::filesystem::path& directory);
std::string report_quality(const Json& record, const std::filesystem::path& directory);
std::string report_scaling(const Json& record, const std::filesystem::path& directory);
std::string report_growth(const Json& record, const std::filesystem::path& directory);
std::string report_parallel(const Json& record, const std::filesystem::path& directory);
std::string report_search(const Json& record, const std::filesystem::path& directory);

/// Says so where the record is of a quick run.
std::string quick_note(const Json& record);

/// Rows of cells; the first is the head.
std::string markdown_table(const std::vector<std::vector<std::string>>& rows);

/// `digits` significant ones, in plain notation.
std::string figure(double value, int digits = 3);

/// Seconds, medians: "0.117", "12.3", "473".
std::string seconds_text(double seconds);

/// Writes NAME.svg, a file of its own, and returns the Markdown that shows it.
std::string picture(const std::filesystem::path& directory, const std::string& name,
                    const std::string& svg, const std::string& caption);

}  // namespace ccvt::bench
