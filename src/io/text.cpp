#include "io/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "number_text.h"

namespace ccvt::io {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
bool is_separator(char c) { return c == ',' || c == ';'; }

bool looks_numeric(std::string_view field) {
  double value = 0;
  // A quoted number is refused as one, not taken for a header.
  if (field.size() > 1 && field.front() == '"' && field.back() == '"') {
    field = field.substr(1, field.size() - 2);
  }
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error != std::errc::invalid_argument && end == field.data() + field.size();
}

/// The names in a header: unlike numbers, they may hold blanks where something else parts them.
std::vector<std::string> split_names(std::string_view line) {
  const char separator = line.find(',') != std::string_view::npos   ? ','
                         : line.find(';') != std::string_view::npos ? ';'
                                                                    : ' ';
  std::vector<std::string> names;
  while (true) {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    if (separator == ' ' && line.empty()) return names;
    std::size_t end = 0;
    while (end < line.size() && line[end] != separator &&
           !(separator == ' ' && is_blank(line[end]))) {
      ++end;
    }
    std::string_view name = line.substr(0, end);
    while (!name.empty() && is_blank(name.back())) name.remove_suffix(1);
    if (name.size() > 1 && name.front() == '"' && name.back() == '"') {
      name = name.substr(1, name.size() - 2);
    }
    names.emplace_back(name);
    if (end == line.size()) return names;
    line.remove_prefix(end + 1);
  }
}

template <class Number>
std::from_chars_result parse_whole(std::string_view field, Number& value) {
  if (field.size() > 1 && field.front() == '+' && field[1] != '-') field.remove_prefix(1);
  const char* const end = field.data() + field.size();
  auto result = std::from_chars(field.data(), end, value);
  if (result.ec == std::errc() && result.ptr != end) result.ec = std::errc::invalid_argument;
  return result;
}

const char* check_finite(double value) {
  return std::isfinite(value) ? nullptr : "is not finite; coordinates must be finite";
}

}  // namespace

TextRows::TextRows(const std::filesystem::path& path) : lines_(path, "a table of numbers") {}

std::string TextRows::split(std::string_view line) {
  fields_.clear();
  std::string problem;
  char separator = 0;  // ' ' stands for blanks alone
  std::size_t at = 0;
  const auto skip_blanks = [&] {
    while (at < line.size() && is_blank(line[at])) ++at;
  };
  skip_blanks();
  if (at == line.size()) return problem;
  for (;;) {
    const std::size_t start = at;
    while (at < line.size() && !is_blank(line[at]) && !is_separator(line[at])) ++at;
    fields_.push_back(line.substr(start, at - start));
    if (start == at) problem = "field " + std::to_string(fields_.size()) + " is empty";
    skip_blanks();
    if (at == line.size()) return problem;
    const char found = is_separator(line[at]) ? line[at] : ' ';
    if (separator != 0 && separator != found) {
      problem = "fields are separated in two ways; use blanks, ',' or ';', and a decimal point";
    }
    separator = found;
    if (found != ' ') ++at;
    skip_blanks();
  }
}

bool TextRows::next() {
  std::string_view line;
  while (lines_.next(line)) {
    if (lines_.number() == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
    line = line.substr(0, line.find('#'));
    const std::string problem = split(line);
    if (fields_.empty()) continue;
    const bool header = first_ && std::none_of(fields_.begin(), fields_.end(), looks_numeric);
    first_ = false;
    if (header) {
      names_ = split_names(line);
      continue;
    }
    if (!problem.empty()) fail(problem);
    return true;
  }
  return false;
}

const char* parse(std::string_view field, double& value) {
  const auto error = parse_whole(field, value).ec;
  if (error == std::errc::result_out_of_range) return "is out of the range of float64";
  if (error != std::errc()) return "is not a number";
  return check_finite(value);
}

const char* parse(std::string_view field, float& value) {
  // Straight to float, so that a float that was written comes back, and not by way of double,
  // which rounds twice. What is too small for float becomes zero.
  const auto error = parse_whole(field, value).ec;
  if (error == std::errc::result_out_of_range) {
    double wide = 0;
    if (parse_whole(field, wide).ec == std::errc() && std::abs(wide) < 1) {
      value = static_cast<float>(wide);
      return nullptr;
    }
    return "is out of the range of float32";
  }
  if (error != std::errc()) return "is not a number";
  return check_finite(value);
}

const char* parse(std::string_view field, std::int32_t& value) {
  const auto error = parse_whole(field, value).ec;
  if (error == std::errc::result_out_of_range) return "does not fit 32 bits";
  return error == std::errc() ? nullptr : "is not a whole number";
}

void append(std::string& text, float value) { append_text(text, value); }
void append(std::string& text, double value) { append_text(text, value); }
void append(std::string& text, std::int32_t value) { append_text(text, value); }

}  // namespace ccvt::io
