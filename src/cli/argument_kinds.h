#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "ccvt/types.h"
#include "cli/arguments.h"
#include "cli/values.h"
#include "io/formats.h"

/// What the commands' options are made of.
namespace ccvt::cli {

/// An option whose value is parsed strictly, with messages that say what it must be.
template <class Number, class Target>
CLI::Option* add_number(CLI::App& app, const std::string& name, Target& target,
                        const std::string& description, const char* placeholder,
                        Range<Number> range) {
  const auto parse = [&target, range](const std::string& text) {
    Number value{};
    const std::string wrong = parse_number(text, range, value);
    if (!wrong.empty()) throw CLI::ValidationError(wrong);
    target = value;
  };
  auto* const option = app.add_option_function<std::string>(name, parse, description);
  option->type_name(placeholder);
  // As a check, so that the message carries the option's name.
  option->check(CLI::Validator(
      [range](std::string& text) {
        Number value{};
        return parse_number(text, range, value);
      },
      ""));
  return option;
}

/// An option whose value `parse(text, target)` understands, or says what is wrong with.
template <class Target, class Parse>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, Target& target, const Parse& parse,
                        const std::string& description, const char* placeholder) {
  return app
      .add_option_function<std::string>(
          name, [&target, parse](const std::string& text) { parse(text, target); }, description)
      ->type_name(placeholder)
      ->check(CLI::Validator(
          [parse](std::string& text) {
            Target scratch;
            return parse(text, scratch);
          },
          ""));
}

/// A file that is read, of one of `extensions`, which the help lists; of none where there are none.
/// It may be standard input: `target` is then the file that stands in for it.
CLI::Option* add_input(CLI::App& app, const std::string& name, std::filesystem::path& target,
                       const std::string& description, io::Extensions extensions = {});
/// The same of a file that is written, and of standard output.
CLI::Option* add_output(CLI::App& app, const std::string& name, std::filesystem::path& target,
                        const std::string& description, io::Extensions extensions = {});
CLI::Option* add_directory(CLI::App& app, const std::string& name, std::filesystem::path& target,
                           const std::string& description);
/// --columns: which columns of the files of points are coordinates.
void add_columns(CLI::App& app, ReadOptions& target);
/// An option without a value.
void add_flag(CLI::App& app, const std::string& name, bool& target, const std::string& description);
void add_sites(CLI::App& app, Index& target, const std::string& description, bool required);
void add_points_per_site(CLI::App& app, Index& target);
void add_seed_and_threads(CLI::App& app, std::uint64_t& seed, int& threads);
/// --checkpoint and --checkpoint-every, for commands that run one Solver.
void add_checkpoint(CLI::App& app, CommonArguments& common);
void add_box(CLI::App& app, std::vector<double>& box, const std::string& description);

/// What all commands that iterate have in common.
void add_run(CLI::App& app, CommonArguments& common);

/// That, and where the sites go: to a file of one of `extensions`.
void add_common(CLI::App& app, CommonArguments& common, io::Extensions extensions,
                const std::string& default_scalar, const std::string& default_until = "blue-noise");

/// Has --output say what samples of volumes and surfaces lose in some files. After add_common().
void describe_samples(CLI::App& app);

/// The arguments, last one first, with all numbers that follow --box made its one value: CLI11
/// would take the file after them for a number, and "-.5" for an option.
std::vector<std::string> reversed_arguments(int argc, const char* const* argv);

}  // namespace ccvt::cli
