#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// What a command's options are, for its help, for manual pages and for shells: all three are made
/// from the options as the program itself knows them.
namespace ccvt::cli {

/// CLI11's group of options that help does not show. With its own, an empty one, they have no name.
constexpr const char* kHiddenGroup = "hidden";

struct OptionHelp {
  std::vector<std::string> names;  ///< with dashes, the short one first; of an argument its name
  std::string value;               ///< a placeholder; empty: a flag
  std::string text;
  bool required = false;
  bool several = false;  ///< takes more than one value

  [[nodiscard]] const std::string& longest() const { return names.back(); }
};

struct OptionGroup {
  std::string title;
  std::vector<OptionHelp> options;
};

/// The arguments without dashes.
std::vector<OptionHelp> arguments_of(const CLI::App& command);

/// The options that are not hidden, in groups, of each what is required first; those groups that
/// have any.
std::vector<OptionGroup> option_groups(const CLI::App& command);

std::vector<const CLI::App*> commands_of(const CLI::App& app);

/// "ccvt sample [OPTIONS] --dim D -o FILE": what a line must have.
std::string usage_of(const CLI::App& command, const std::string& name);

/// What a FILE may be besides a file; empty where the command takes none, or streams are refused.
std::string streams_text(const CLI::App& command);

/// Prints help in groups, in lines that fit into 100 columns.
class HelpFormatter : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* command, std::string name,
                        CLI::AppFormatMode mode) const override;
};

}  // namespace ccvt::cli
