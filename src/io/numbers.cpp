#include <cmath>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "io/formats.h"
#include "io/input_file.h"
#include "io/npy.h"
#include "io/npy_numbers.h"
#include "number_text.h"

namespace ccvt {
namespace {

/// Of an .npy file of one extent; nothing of others.
std::vector<double> read_npy_vector(const std::filesystem::path& path) {
  io::InputFile file(path);
  const io::NpyHeader header = io::read_npy_header(file);
  const auto item = io::parse_npy_descr(header.descr);
  if (header.shape.size() != 1 || !item) return {};
  io::check_npy_size(file, header, item->bytes);
  std::vector<double> numbers;
  numbers.reserve(header.shape[0]);
  io::read_npy_numbers(file, *item, header.shape[0], [&](auto number) {
    const auto value = static_cast<double>(number);
    if (!std::isfinite(value)) {
      file.fail("row " + std::to_string(numbers.size()) + ": " + text(value) +
                " is not finite; numbers must be finite");
    }
    numbers.push_back(value);
  });
  if (numbers.empty()) file.fail("has no numbers");
  return numbers;
}

}  // namespace

std::vector<double> read_numbers(const std::filesystem::path& path) {
  if (io::extension_of(path) == ".npy") {
    std::vector<double> numbers = read_npy_vector(path);
    if (!numbers.empty()) return numbers;
  }
  // Those of all columns, whichever of them would be coordinates of points.
  const PointsHeader header = inspect_points(path);
  std::vector<std::string> names = header.columns;
  names.insert(names.end(), header.left_out.begin(), header.left_out.end());
  const auto numbers = static_cast<std::size_t>(header.dimension) + header.left_out.size();
  if (numbers != 1) {
    throw InvalidInput(path.string() + ": has " + std::to_string(numbers) + " numbers a row" +
                       (names.empty() ? "" : " (" + io::list_of(names) + ")") +
                       "; there must be one");
  }
  const Points<double> column = read_points<double>(path);
  return {column.data(), column.data() + column.size()};
}

}  // namespace ccvt
