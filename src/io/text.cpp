#include "io/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "io/whole.h"
#include "number_text.h"

namespace ccvt::io {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
bool is_separator(char c) { return c == ',' || c == ';'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

bool is_quoted(std::string_view field) {
  return field.size() > 1 && field.front() == '"' && field.back() == '"';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Calls visit(place, letter) for the letters that are not between quotes, until it says so.
template <class Visit>
void visit_unquoted(std::string_view line, const Visit& visit) {
  bool quoted = false;
  for (std::size_t at = 0; at < line.size(); ++at) {
    if (line[at] == '"') quoted = !quoted;
    if (!quoted && !visit(at, line[at])) return;
  }
}

/// A line up to its comment.
std::string_view without_comment(std::string_view line) {
  if (line.find('#') == std::string_view::npos) return line;
  std::size_t end = line.size();
  visit_unquoted(line, [&](std::size_t at, char c) {
    if (c == '#') end = at;
    return c != '#';
  });
  return line.substr(0, end);
}

/// What parts the fields of a line: what parted those before, or a comma, or a semicolon, or else
/// blanks.
char separator_of(std::string_view line, char before) {
  const char preferred = before == ' ' ? ',' : before;
  char found = ' ';
  visit_unquoted(line, [&](std::size_t, char c) {
    if (c == preferred || (found == ' ' && is_separator(c))) found = c;
    return c != preferred;
  });
  return found;
}

bool looks_numeric(std::string_view field) {
  double value = 0;
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error != std::errc::invalid_argument && end == field.data() + field.size();
}

template <class Number>
std::from_chars_result parse_whole(std::string_view field, Number& value) {
  if (field.size() > 1 && field.front() == '+' && field[1] != '-') field.remove_prefix(1);
  const char* const end = field.data() + field.size();
  auto result = std::from_chars(field.data(), end, value);
  if (result.ptr != end) result.ec = std::errc::invalid_argument;
  return result;
}

/// Whether a number, of whatever size, is below 1, as its digits and its exponent tell.
bool is_below_one(std::string_view field) {
  constexpr std::int64_t kFar = std::int64_t{1} << 40;
  const std::size_t mark = std::min(field.find_first_of("eE"), field.size());
  const std::string_view digits = field.substr(0, mark);
  std::int64_t exponent = 0;
  if (mark < field.size()) {
    const std::string_view written = field.substr(mark + 1);
    const bool fits = parse_whole(written, exponent).ec == std::errc();
    if (!fits || std::abs(exponent) > kFar) exponent = written.front() == '-' ? -kFar : kFar;
  }
  const std::size_t point = std::min(digits.find('.'), digits.size());
  const std::size_t first = std::min(digits.find_first_of("123456789"), digits.size());
  // The first digit that counts is worth 10 to the power of this.
  const auto before = static_cast<std::int64_t>(point) - static_cast<std::int64_t>(first);
  return exponent + (first < point ? before - 1 : before) < 0;
}

/// Zero, for a number that is out of range because it is too near to that.
template <class Scalar>
const char* parse_tiny(std::string_view field, Scalar& value, const char* otherwise) {
  if (!is_below_one(field)) return otherwise;
  value = std::copysign(Scalar(0), field.front() == '-' ? Scalar(-1) : Scalar(1));
  return nullptr;
}

const char* check_finite(double value) {
  return std::isfinite(value) ? nullptr : "is not finite; coordinates must be finite";
}

}  // namespace

TextRows::TextRows(const std::filesystem::path& path) : lines_(path, "a table of numbers") {}

char TextRows::separator_of_next(std::string_view line) const {
  const char separator = separator_of(line, separator_ == '\t' ? ' ' : separator_);
  if (separator != ' ' || !(first_ || names_separator_ == '\t')) return separator;
  std::size_t tabs = 0;
  visit_unquoted(first_ ? trimmed(line) : line, [&](std::size_t, char c) {
    if (c == '\t') ++tabs;
    return true;
  });
  return (first_ ? tabs > 0 : tabs + 1 == names_.size()) ? '\t' : ' ';
}

/// Text between quotes, of a column that nobody reads, may hold anything.
void TextRows::split(std::string_view line, char separator) {
  separator_ = separator;
  fields_.clear();
  texts_.clear();
  if (separator != '\t') line = trimmed(line);
  const auto parts = [&](char c) { return separator == ' ' ? is_blank(c) : c == separator; };
  std::size_t start = 0;
  const auto end_field = [&](std::size_t end) {
    const std::string_view field = trimmed(line.substr(start, end - start));
    start = end + 1;
    if (separator == ' ' && field.empty()) return;  // several blanks
    fields_.push_back(is_quoted(field) ? field.substr(1, field.size() - 2) : field);
    texts_.push_back(field);
  };
  visit_unquoted(line, [&](std::size_t at, char c) {
    if (parts(c)) end_field(at);
    return true;
  });
  end_field(line.size());
}

/// Lines that end with carriage returns alone would be one line.
void TextRows::check_returns(std::string_view line) const {
  visit_unquoted(line, [this](std::size_t, char c) {
    if (c == '\r') fail("has a carriage return inside; end lines with line feeds");
    return true;
  });
}

bool TextRows::next() {
  std::string_view line;
  while (lines_.next(line)) {
    if (lines_.number() == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
    if (lines_.number() == 1 && line.starts_with("\x93NUMPY")) {
      fail("is NumPy data, not text: a file is to end in .npy, and standard input is npy:-");
    }
    while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.find('\r') != std::string_view::npos) check_returns(line);
    line = without_comment(line);
    if (trimmed(line).empty()) continue;
    split(line, separator_of_next(line));
    const bool header = first_ && std::none_of(fields_.begin(), fields_.end(), looks_numeric);
    if (header) {
      names_.assign(fields_.begin(), fields_.end());
      names_separator_ = separator_;
      names_line_ = lines_.number();
    } else if (first_ && separator_ == '\t') {
      split(line, ' ');
    }
    first_ = false;
    if (!header) return true;
  }
  return false;
}

std::vector<std::string> TextRows::names() const {
  if (names_.size() == fields_.size()) return names_;
  // A title has blanks, or what parts no fields.
  const bool list = names_separator_ == separator_ || names_separator_ == '\t';
  if (names_.size() < 2 || names_separator_ == ' ' || !list) return {};
  fail("has " + std::to_string(fields_.size()) + " fields, but line " +
       std::to_string(names_line_) + " names " + std::to_string(names_.size()) +
       " columns; all columns need a name, or none");
}

void TextRows::fail_field(std::size_t at, const char* wrong) const {
  const std::string_view field = fields_[at];
  const std::string which = "field " + std::to_string(at + 1);
  if (field.empty()) fail(which + " is empty, but must be a number");
  const auto parts = [](char c) { return is_separator(c) || is_blank(c); };
  if (std::any_of(field.begin(), field.end(), parts) &&
      std::none_of(field.begin(), field.end(), is_letter)) {
    fail("fields are separated in two ways; use blanks, ',' or ';', and a decimal point");
  }
  fail(which + ": " + quoted(field) + " " + wrong);
}

const char* parse(std::string_view field, double& value) {
  // What is too small becomes zero, as in float.
  const auto error = parse_whole(field, value).ec;
  if (error == std::errc::result_out_of_range) {
    return parse_tiny(field, value, "is out of the range of float64");
  }
  if (error != std::errc()) return "is not a number";
  return check_finite(value);
}

const char* parse(std::string_view field, float& value) {
  // Straight to float, so that a float that was written comes back, and not by way of double,
  // which rounds twice. What is too small for float becomes zero.
  const auto error = parse_whole(field, value).ec;
  if (error == std::errc::result_out_of_range) {
    return parse_tiny(field, value, "is out of the range of float32");
  }
  if (error != std::errc()) return "is not a number";
  return check_finite(value);
}

const char* parse(std::string_view field, std::int32_t& value) {
  const auto error = parse_whole(field, value).ec;
  if (error == std::errc()) return nullptr;
  // As numpy.savetxt() writes whole numbers: 1.000000000000000000e+02.
  double number = 0;
  const auto wide = parse_whole(field, number).ec;
  if (wide == std::errc()) return to_whole(number, value);
  const bool vast = wide == std::errc::result_out_of_range && !is_below_one(field);
  return vast ? "does not fit 32 bits" : "is not a whole number";
}

void append_field(std::string& text, std::string_view field, char separator) {
  const auto parts = [&](char c) { return is_separator(c) || (separator == ' ' && is_blank(c)); };
  const bool whole =
      is_quoted(field) ||
      (trimmed(field).size() == field.size() && std::none_of(field.begin(), field.end(), parts) &&
       field.find('#') == std::string_view::npos && !(separator == ' ' && field.empty()));
  if (whole) {
    text += field;
    return;
  }
  text += '"';
  for (const char c : field) text.append(c == '"' ? 2 : 1, c);
  text += '"';
}

void append(std::string& text, float value) { append_text(text, value); }
void append(std::string& text, double value) { append_text(text, value); }
void append(std::string& text, std::int32_t value) { append_text(text, value); }

}  // namespace ccvt::io
