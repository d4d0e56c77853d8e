#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/io.h"

namespace ccvt::io {

/// Numbers of each sample: real ones, or whole ones.
struct SampleColumn {
  std::string name;                  ///< of the array, where a file has such
  std::vector<std::string> columns;  ///< the name of each of its components
  std::span<const double> reals;     ///< components of a sample in a row; empty: whole numbers
  std::span<const Index> integers;

  SampleColumn(const char* own, std::span<const double> values)
      : name(own), columns({own}), reals(values) {}
  SampleColumn(const char* own, std::span<const Index> values)
      : name(own), columns({own}), integers(values) {}
  SampleColumn(const char* own, std::vector<std::string> parts, std::span<const double> values)
      : name(own), columns(std::move(parts)), reals(values) {}

  [[nodiscard]] std::size_t components() const { return columns.size(); }
};

/// What is written of samples: where they are, and numbers of each. Views.
struct SampleTable {
  const Columns<double>& sites;
  std::span<const double> radii;
  ScalarType scalar;  ///< what they were computed in
  std::vector<SampleColumn> columns;
};

/// Writes samples by extension, see write_samples() in volume.h. Real numbers are float64 when the
/// samples were computed in that, or when float32 would move a site by more than a thousandth of
/// the mean radius, or leave its range; else float32. Errors are those of the other writers.
void write_sample_table(const std::filesystem::path& path, const SampleTable& table);

}  // namespace ccvt::io
