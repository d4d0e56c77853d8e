#include "cli/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "number_text.h"

namespace ccvt::cli {

namespace {

constexpr std::size_t kBarWidth = 14;
constexpr auto kInterval = std::chrono::milliseconds(50);

template <class... Values>
std::string printed(const char* format, Values... values) {
  char text[100];
  const int length = std::snprintf(text, sizeof text, format, values...);
  return {text, static_cast<std::size_t>(std::max(length, 0))};
}

std::size_t terminal_width() {
  struct winsize size = {};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

/// Whether standard error is a terminal on which a line can be drawn again.
bool can_redraw() {
  if (::isatty(STDERR_FILENO) == 0) return false;
  const char* const kind = std::getenv("TERM");  // NOLINT(concurrency-mt-unsafe): nobody sets it
  return kind == nullptr || std::string_view(kind) != "dumb";
}

}  // namespace

Progress::Progress(bool quiet, double time_limit)
    : live_(!quiet && can_redraw()), time_limit_(time_limit), last_(Clock::now() - kInterval) {}

Progress::~Progress() { clear(); }

void Progress::clear() {
  if (drawn_ > 0) redraw("");
}

void Progress::redraw(const std::string& text) {
  // Blanks and not an escape code: terminals differ in these, and what records them shows them.
  const std::size_t blanks = drawn_ - std::min(drawn_, text.size());
  const std::string line = "\r" + text + std::string(blanks, ' ') + (text.empty() ? "\r" : "");
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
  drawn_ = text.size();
}

void Progress::show(const IterationRecord& record, Index sites) {
  const auto now = Clock::now();
  if (!live_ || now - last_ < kInterval) return;
  last_ = now;
  const double active = 1.0 * record.active_sites / std::max(sites, Index{1});
  const auto settled =
      static_cast<std::size_t>(std::clamp(record.progress, 0.0, 1.0) * kBarWidth + 0.5);
  // What is done is not quite proportional to time; early on, not at all.
  double left = record.seconds * (1 / std::max(record.progress, 1e-9) - 1);
  if (time_limit_ > 0) left = std::min(left, time_limit_ - record.seconds);
  const bool foreseeable = record.progress > 0.05 && record.seconds > 1 && left >= 1;
  const std::string bar =
      "[" + std::string(settled, '#') + std::string(kBarWidth - settled, '.') + "]";
  const std::string time =
      printed("  %.1f s", record.seconds) +
      (foreseeable ? ", about " + ccvt::text(left, 2) + " s left" : std::string());
  // Where there is no room for all, the time is what counts.
  std::string line = bar;
  for (const std::string& part :
       {printed(" level %d/%d  iteration %d", record.level + 1, record.levels, record.iteration),
        printed("  active %4.1f %%", 100 * active), printed("  energy %.5g", record.energy)}) {
    if (line.size() + part.size() + time.size() < terminal_width()) line += part;
  }
  redraw((line + time).substr(0, terminal_width() - 1));
}

}  // namespace ccvt::cli
