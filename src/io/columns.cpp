#include "io/columns.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <system_error>

#include "io/formats.h"

namespace ccvt::io {

namespace {

/// "its columns are 'x', 'y'": as many as a line bears.
std::string list_of(const std::vector<std::string>& names, std::size_t count) {
  if (names.empty()) {
    return "its columns have no names, only numbers, from 1 to " + std::to_string(count);
  }
  constexpr std::size_t most = 12;
  std::string list = "its columns are ";
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i) {
    list += (i > 0 ? ", " : "") + io::quoted(names[i]);
  }
  return list + (names.size() > most ? " and more" : "");
}

/// Finds columns by their names.
class Directory {
 public:
  Directory(const InputFile& file, const std::vector<std::string>& names) : file_(file) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto [entry, added] = at_.try_emplace(names[i], i);
      if (!added) entry->second = kTwice;
    }
  }

  [[nodiscard]] std::optional<std::size_t> find(const std::string& name) const {
    const auto found = at_.find(name);
    if (found == at_.end()) return {};
    if (found->second == kTwice) {
      file_.fail("has two columns " + io::quoted(name) +
                 "; say which are coordinates by their numbers");
    }
    return found->second;
  }

 private:
  static constexpr auto kTwice = std::numeric_limits<std::size_t>::max();
  const InputFile& file_;
  std::map<std::string, std::size_t> at_;
};

std::vector<std::size_t> find_wanted(const InputFile& file, const std::vector<std::string>& wanted,
                                     const std::vector<std::string>& names, std::size_t count) {
  const Directory directory(file, names);
  std::vector<std::size_t> at;
  for (const std::string& name : wanted) {
    std::size_t number = 0;
    const char* const end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data(), end, number);
    if (const auto found = directory.find(name)) {
      number = *found + 1;
    } else if (error != std::errc() || stop != end || number < 1 || number > count) {
      file.fail("has no column " + io::quoted(name) + ": " + list_of(names, count));
    }
    if (std::find(at.begin(), at.end(), number - 1) != at.end()) {
      file.fail("column " + io::quoted(name) + " is asked for twice; coordinates must differ");
    }
    at.push_back(number - 1);
  }
  return at;
}

/// Empty where there is neither x nor x0.
std::vector<std::size_t> coordinates_among(const InputFile& file,
                                           const std::vector<std::string>& names) {
  std::vector<std::string> lower(names.size());
  std::transform(names.begin(), names.end(), lower.begin(), in_lower_case);
  const Directory directory(file, lower);
  std::vector<std::size_t> at;
  if (directory.find("x")) {
    for (const char* const name : {"x", "y", "z"}) {
      if (const auto found = directory.find(name)) at.push_back(*found);
    }
    return at;
  }
  while (const auto found = directory.find("x" + std::to_string(at.size()))) at.push_back(*found);
  return at;
}

std::vector<std::size_t> all_of(std::size_t count) {
  std::vector<std::size_t> at(count);
  std::iota(at.begin(), at.end(), std::size_t{0});
  return at;
}

}  // namespace

TableColumns choose_columns(const InputFile& file, const std::vector<std::string>& wanted,
                            const std::vector<std::string>& names, std::size_t count) {
  TableColumns columns;
  columns.at =
      wanted.empty() ? coordinates_among(file, names) : find_wanted(file, wanted, names, count);
  columns.unknown = columns.at.empty();
  if (columns.unknown) columns.at = all_of(count);
  if (names.empty()) return columns;
  columns.reordered = wanted.empty() && !std::is_sorted(columns.at.begin(), columns.at.end());
  std::vector<bool> chosen(count, false);
  for (const std::size_t at : columns.at) {
    chosen[at] = true;
    columns.names.push_back(names[at]);
  }
  for (std::size_t i = 0; i < count && wanted.empty(); ++i) {
    if (!chosen[i]) columns.left_out.push_back(names[i]);
  }
  return columns;
}

}  // namespace ccvt::io
