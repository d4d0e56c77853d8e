#include "cli/argument_kinds.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <sstream>
#include <string_view>

#include "ccvt/presets.h"
#include "cli/standard_streams.h"

namespace ccvt::cli {

namespace {

/// Parses numbers separated by blanks or commas; returns what is wrong with them, or nothing.
std::string parse_box(std::string text, std::vector<double>& box) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream fields(text);
  std::string wrong;
  for (std::string field; wrong.empty() && fields >> field;) {
    wrong = parse_number(field, Range<double>{}, box.emplace_back());
  }
  return box.empty() ? "has no numbers" : wrong;
}

std::string parse_columns(const std::string& text, std::vector<std::string>& columns) {
  columns.clear();
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    if (end == begin) return "'" + text + "' has an empty name; names are separated by commas";
    columns.push_back(text.substr(begin, end - begin));
    if (end == text.size()) return {};
    begin = end + 1;
  }
}

template <class Take>
CLI::Option* add_path(CLI::App& app, const std::string& name, const Take& take,
                      const std::string& description, const char* placeholder) {
  auto* const option = app.add_option_function<std::string>(name, take, description);
  option->type_name(placeholder);
  option->check(CLI::Validator(
      [](std::string& text) -> std::string {
        if (text.empty()) return "is empty";
        // Of -o=FILE.
        if (text.front() == '=') {
          return "'" + text + "' begins with '='; a file of that name is './" + text + "'";
        }
        return {};
      },
      ""));
  return option;
}

/// Of `name`, "-o,--output", the long one.
std::string long_name(const std::string& name) { return name.substr(name.find(',') + 1); }

CLI::Option* add_file(CLI::App& app, const std::string& name, std::filesystem::path& target,
                      const std::string& description, Stream stream, io::Extensions extensions) {
  const auto end = std::min(description.find(" ["), description.size());  // a default comes last
  const std::string kinds = extensions.empty() ? "" : ": " + io::list_of(extensions);
  return add_path(
      app, name,
      [&target, stream, extensions, option = long_name(name)](const std::string& text) {
        target = file_of(option, text, stream, extensions);
      },
      description.substr(0, end) + kinds + description.substr(end), "FILE");
}

}  // namespace

CLI::Option* add_input(CLI::App& app, const std::string& name, std::filesystem::path& target,
                       const std::string& description, io::Extensions extensions) {
  return add_file(app, name, target, description, Stream::input, extensions);
}

CLI::Option* add_output(CLI::App& app, const std::string& name, std::filesystem::path& target,
                        const std::string& description, io::Extensions extensions) {
  return add_file(app, name, target, description, Stream::output, extensions);
}

CLI::Option* add_directory(CLI::App& app, const std::string& name, std::filesystem::path& target,
                           const std::string& description) {
  return add_path(
      app, name,
      [&target, name](const std::string& text) {
        if (names_stream(text)) {
          throw CLI::ValidationError(long_name(name) + ": '" + text +
                                     "' cannot be a stream: a directory of files is written");
        }
        target = text;
      },
      description, "DIR");
}

void add_columns(CLI::App& app, ReadOptions& target) {
  add_parsed(app, "--columns", target.columns, parse_columns,
             "Which columns are coordinates: names in a header or of PLY properties, or numbers "
             "from 1 [those named x, y, z or x0, x1, ..., if there are any, else all]",
             "A,B,..");
}

void add_flag(CLI::App& app, const std::string& name, bool& target,
              const std::string& description) {
  app.add_flag(name, target, description)->disable_flag_override();
}

void add_sites(CLI::App& app, Index& target, const std::string& description, bool required) {
  add_number<Index>(app, "--sites", target, description, "N", {.least = 1})->required(required);
}

void add_points_per_site(CLI::App& app, Index& target) {
  add_number<Index>(app, "--points-per-site", target, "Points for each site [256]", "K",
                    {.least = 1});
}

void add_seed_and_threads(CLI::App& app, std::uint64_t& seed, int& threads) {
  add_number<std::uint64_t>(app, "--seed", seed, "Fixes every random choice [0]", "S",
                            {.least = 0});
  add_number<int>(app, "--threads", threads,
                  "Threads; 0: one per processor [0]. The result is the same for any number", "T",
                  {.least = 0, .most = 4096});
}

void add_run(CLI::App& app, CommonArguments& common) {
  common.command = app.get_name();
  add_seed_and_threads(app, common.seed, common.threads);
  add_number<int>(app, "--max-iterations", common.max_iterations,
                  "Stop after this many iterations [no limit]", "K", {.least = 0});
  add_number<double>(app, "--energy-tolerance", common.energy_tolerance,
                     "Stop when an iteration lowers the energy by less than this share [0]", "E",
                     {.least = 0, .most = 1, .open_above = true});
  add_number<double>(app, "--time-limit", common.time_limit,
                     "End after so many seconds with what has been reached [none]", "SECONDS",
                     {.least = 0, .most = std::numeric_limits<double>::max(), .open_below = true});
  add_output(app, "--summary", common.summary, "Write a summary of the run as JSON");
  add_flag(app, "-q,--quiet", common.quiet, "Print nothing but errors");
}

void add_common(CLI::App& app, CommonArguments& common, io::Extensions extensions,
                const std::string& default_scalar, const std::string& default_until) {
  add_output(app, "-o,--output", common.output, "Where the sites go", extensions)->required();
  add_run(app, common);
  app.add_option("--preset", common.preset,
                 "The method and its end: a row of the benchmarks' table, such as fast-ccvt; "
                 "threads are as --threads says, and the end as --until where that is given too")
      ->type_name("NAME")
      ->check(CLI::Validator(
          [](std::string& name) {
            try {
              find_preset(name);
              return std::string();
            } catch (const InvalidInput& error) {
              const std::string_view reason = error.what();
              return std::string(reason.substr(reason.find(' ') + 1));  // "--preset: " precedes it
            }
          },
          ""));
  static const std::map<std::string, Until> ends = {{"stable", Until::stable},
                                                    {"blue-noise", Until::blue_noise}};
  app.add_option_function<std::string>(
         "--until", [&common](const std::string& name) { common.until = ends.at(name); },
         "With 512 points a site and more: stable (least energy; a lattice with faults, from "
         "thousands on) or blue-noise (about as irregular as with 1024, and sooner) [" +
             default_until + "]")
      ->type_name("END")
      ->check(CLI::Validator(
          [](std::string& name) {
            if (ends.contains(name)) return std::string();
            return "'" + name + "' is not stable or blue-noise";
          },
          ""));
  auto* const single = app.add_flag_function(
      "--float", [&common](std::int64_t) { common.scalar = ScalarType::float32; },
      "Compute and write in float32" +
          std::string(default_scalar == "float32" ? " [default]" : ""));
  auto* const wide = app.add_flag_function(
      "--double", [&common](std::int64_t) { common.scalar = ScalarType::float64; },
      "Compute and write in float64" +
          std::string(default_scalar == "float32" ? "" : " [default: " + default_scalar + "]"));
  single->disable_flag_override()->excludes(wide->disable_flag_override());
}

void add_checkpoint(CLI::App& app, CommonArguments& common) {
  auto* const directory = add_directory(
      app, "--checkpoint", common.checkpoint,
      "Keep the run there, and go on from there when it is run again after it was stopped or "
      "killed: with the same result as if it had not been [none]");
  add_number<double>(app, "--checkpoint-every", common.checkpoint_every,
                     "At the least so long from one checkpoint to the next; 0: after each "
                     "iteration [600]",
                     "SECONDS", {.least = 0, .most = std::numeric_limits<double>::max()})
      ->needs(directory);
}

void add_box(CLI::App& app, std::vector<double>& box, const std::string& description) {
  app.add_option_function<std::string>(
         "--box", [&box](const std::string& text) { parse_box(text, box); },
         description + ": all lower bounds, then all upper bounds")
      ->type_name("LO.. HI..")
      ->check(CLI::Validator(
          [](std::string& text) {
            std::vector<double> numbers;
            return parse_box(text, numbers);
          },
          ""));
}

void describe_samples(CLI::App& app) {
  auto* const output = app.get_option("--output");
  output->description(output->get_description() + "; .npy has the sites alone, in float64");
}

std::vector<std::string> reversed_arguments(int argc, const char* const* argv) {
  // What is a number to C, such as nan, is --box's to refuse.
  const auto is_number = [](const char* text) {
    char* end = nullptr;
    std::strtod(text, &end);
    return end != text && *end == '\0';
  };
  std::vector<std::string> result;
  for (int i = 1; i < argc; ++i) {
    std::string& word = result.emplace_back(argv[i]);
    constexpr std::string_view begun = "--box=";
    const bool has_first = word.starts_with(begun) && is_number(argv[i] + begun.size());
    if (word != "--box" && !has_first) continue;
    for (; i + 1 < argc && is_number(argv[i + 1]); ++i) {
      word += (word == "--box" ? "=" : " ") + std::string(argv[i + 1]);
    }
  }
  std::reverse(result.begin(), result.end());
  return result;
}

}  // namespace ccvt::cli
