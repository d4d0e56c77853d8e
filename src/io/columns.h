#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "io/input_file.h"

namespace ccvt::io {

/// Which columns of a table are coordinates, in their order.
struct TableColumns {
  std::vector<std::size_t> at;        ///< from 0
  std::vector<std::string> names;     ///< of them; empty where columns have none
  std::vector<std::string> left_out;  ///< names of the others, where the names alone decided
  bool unknown = false;    ///< all are taken, for nobody said which, and their names do not tell
  bool reordered = false;  ///< by their names

  /// Of the points.
  [[nodiscard]] int dimension() const { return static_cast<int>(at.size()); }
};

/// `wanted`: names, or numbers from 1; a name that is a number goes first. Empty: the columns named
/// x, y and z, as many as there are of them, or x0, x1, …, in either case; all where there is no x
/// or x0. `names`: one for each of `count` columns, or none. Throws InvalidInput for what is not
/// there, is there twice, or is wanted twice, with a list of what is there.
TableColumns choose_columns(const InputFile& file, const std::vector<std::string>& wanted,
                            const std::vector<std::string>& names, std::size_t count);

}  // namespace ccvt::io
