#include "cli/volume_input.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "cli/outputs.h"
#include "cli/standard_streams.h"
#include "cli/values.h"
#include "io/formats.h"

namespace ccvt::cli {

namespace {

/// Whether all values beyond some have the same density.
bool has_limits(const ValueMap& map) {
  return map.kind == ValueMap::Kind::window || map.kind == ValueMap::Kind::threshold;
}

[[noreturn]] void refuse_value(const VolumeArguments& arguments, std::uint64_t cell, double value) {
  const std::string file = arguments.volume.string();
  throw InvalidInput(
      file + ": value " + std::to_string(cell) + " is " + concat(value) +
      (std::isnan(value)
           ? "; leave such cells out with --mask FILE, a volume that is 0 or NaN there: " + file +
                 " itself would do"
           : "; choose which values matter with --map window:LO,HI or --map threshold:T"));
}

}  // namespace

bool is_raw(const std::filesystem::path& file) { return io::extension_of(file) == ".raw"; }

VolumeHeader inspect_input(const std::filesystem::path& file, const VolumeLayout& layout) {
  if (is_raw(file) && (layout.shape.empty() || !layout.type)) {
    throw InvalidInput(
        with_names_of_streams(file.string()) +
        ": is a raw file; needs a shape of 3 numbers and a type: --shape X,Y,Z --type TYPE");
  }
  VolumeHeader header = inspect_volume(file, layout);
  if (is_from_stream(file) && header.data_file != file) {
    throw InvalidInput(with_names_of_streams(file.string()) +
                       ": its header names a data file, which a stream has no directory for; name "
                       "the header as a file");
  }
  return header;
}

void check_values(const VolumeArguments& arguments, const Volume& volume,
                  const std::vector<std::uint8_t>& mask) {
  check_range(arguments, check_each_value(arguments, volume, mask, 0));
}

ValueRange check_each_value(const VolumeArguments& arguments, const Volume& part,
                            const std::vector<std::uint8_t>& mask, std::uint64_t first_cell) {
  ValueRange values;
  visit_values(part, [&](std::size_t i, double value) {
    if (!mask.empty() && mask[i] == 0) return;
    if (std::isnan(value) || (!has_limits(arguments.map) && std::isinf(value))) {
      refuse_value(arguments, first_cell + i, value);
    }
    values.least = std::min(values.least, value);
    values.most = std::max(values.most, value);
  });
  return values;
}

void check_range(const VolumeArguments& arguments, const ValueRange& values) {
  if (has_limits(arguments.map) || arguments.map.invert || !(values.least < 0)) return;
  throw InvalidInput(arguments.volume.string() + ": has values from " + concat(values.least) +
                     " to " + concat(values.most) +
                     ", but a density is not negative; choose which values matter with --map "
                     "window:LO,HI (0 up to LO, full from HI) or --map threshold:T");
}

}  // namespace ccvt::cli
