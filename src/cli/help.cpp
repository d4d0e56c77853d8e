#include "cli/help.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "cli/standard_streams.h"

namespace ccvt::cli {

namespace {

constexpr std::size_t kTextColumn = 34;
constexpr std::size_t kLineWidth = 100;

constexpr std::array kTitles = {"Problem", "Input", "Output", "Method", "Run"};

/// The title under which an option stands: that of its name with its command's, or of its name.
std::string_view title_of(const CLI::App& command, const std::string& name) {
  static const std::map<std::string_view, std::string_view> titles = {
      {"--columns", "Input"},
      {"--capacities", "Input"},
      {"--initial-sites", "Input"},
      {"--fixed-sites", "Input"},
      {"--masses", "Input"},
      {"--mass-column", "Input"},
      {"--mask", "Input"},
      {"--label", "Input"},
      {"--spacing", "Input"},
      {"--origin", "Input"},
      {"--shape", "Input"},
      {"--type", "Input"},
      {"--mask-type", "Input"},
      {"--image-blocks", "Input"},
      {"--compare", "Input"},
      {"--codebook", "Input"},
      {"--weights", "Input"},
      {"--output", "Output"},
      {"--points-out", "Output"},
      {"--owners-out", "Output"},
      {"--shares-out", "Output"},
      {"--indices-out", "Output"},
      {"--codes-out", "Output"},
      {"--weights-out", "Output"},
      {"--image-out", "Output"},
      {"--preview", "Output"},
      {"--up", "Output"},
      {"--summary", "Output"},
      {"--dot-radius", "Output"},
      {"--box-size", "Output"},
      {"--repeat", "Output"},
      {"sample --density", "Output"},
      {"--redshift", "Output"},
      {"--gas", "Output"},
      {"--gadget-format", "Output"},
      {"--help", "Run"},
      {"--preset", "Method"},
      {"--until", "Method"},
      {"--mass-method", "Method"},
      {"--method", "Method"},
      {"--seeding", "Method"},
      {"--restarts", "Method"},
      {"--effort", "Method"},
      {"--gap", "Method"},
      {"--train-sample", "Method"},
      {"--max-iterations", "Method"},
      {"--energy-tolerance", "Method"},
      {"--seed", "Method"},
      {"--float", "Method"},
      {"--double", "Method"},
      {"--max-frequency", "Method"},
      {"--time-limit", "Run"},
      {"--checkpoint", "Run"},
      {"--checkpoint-every", "Run"},
      {"--threads", "Run"},
      {"--quiet", "Run"},
      {"--version", "Run"},
  };
  const auto own = titles.find(command.get_name() + " " + name);
  const auto found = own != titles.end() ? own : titles.find(name);
  return found == titles.end() ? kTitles.front() : found->second;
}

OptionHelp help_of(const CLI::Option& option) {
  OptionHelp help;
  if (option.get_positional()) {
    help.names.push_back(option.get_single_name());
  } else {
    for (const std::string& name : option.get_snames()) help.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) help.names.push_back("--" + name);
  }
  if (option.get_items_expected_max() > 0) help.value = option.get_type_name();
  help.text = option.get_description();
  help.required = option.get_required();
  help.several = option.get_items_expected_max() > 1;
  return help;
}

std::string heading(const OptionHelp& option) {
  std::string text;
  for (const std::string& name : option.names) text += (text.empty() ? "" : ",") + name;
  if (!option.value.empty()) text += " " + option.value + (option.several ? " ..." : "");
  return text + (option.required ? " (required)" : "");
}

/// `text` in lines of kLineWidth that begin in kTextColumn, behind `head`.
std::string entry(const std::string& head, std::string_view text) {
  std::string lines = "  " + head;
  std::size_t column = lines.size();
  const auto go_to_column = [&] {
    lines.append(kTextColumn - column, ' ');
    column = kTextColumn;
  };
  if (column >= kTextColumn) {
    lines += '\n';
    column = 0;
  }
  go_to_column();
  while (!text.empty()) {
    const std::size_t length = std::min(text.find(' '), text.size());
    if (column > kTextColumn && column + 1 + length > kLineWidth) {
      lines += '\n';
      column = 0;
      go_to_column();
    }
    if (column > kTextColumn) lines += ' ', ++column;
    lines += text.substr(0, length);
    column += length;
    text.remove_prefix(std::min(length + 1, text.size()));
  }
  return lines + "\n";
}

}  // namespace

std::vector<OptionHelp> arguments_of(const CLI::App& command) {
  std::vector<OptionHelp> arguments;
  for (const CLI::Option* const option : command.get_options()) {
    if (option->get_positional()) arguments.push_back(help_of(*option));
  }
  return arguments;
}

std::vector<OptionGroup> option_groups(const CLI::App& command) {
  std::vector<OptionGroup> groups;
  for (const char* const title : kTitles) {
    OptionGroup group{title, {}};
    for (const CLI::Option* const option : command.get_options()) {
      if (option->get_positional() || option->get_group() == kHiddenGroup) continue;
      OptionHelp help = help_of(*option);
      if (title_of(command, help.longest()) == title) group.options.push_back(std::move(help));
    }
    std::stable_partition(group.options.begin(), group.options.end(),
                          [](const OptionHelp& option) { return option.required; });
    if (!group.options.empty()) groups.push_back(std::move(group));
  }
  return groups;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::string usage_of(const CLI::App& command, const std::string& name) {
  std::string line = name;
  if (!commands_of(command).empty()) return line + " COMMAND [OPTIONS]";
  for (const OptionHelp& argument : arguments_of(command)) {
    line += " " + argument.longest() + (argument.several ? "..." : "");
  }
  for (const OptionGroup& group : option_groups(command)) {
    for (const OptionHelp& option : group.options) {
      if (option.required) line += " " + option.names.front() + " " + option.value;
    }
  }
  return line + " [OPTIONS]";
}

std::string streams_text(const CLI::App& command) {
  if (streams_are_refused()) return "";
  const auto is_file = [](const CLI::Option* option) { return option->get_type_name() == "FILE"; };
  const std::vector<const CLI::Option*> options = command.get_options();
  if (std::none_of(options.begin(), options.end(), is_file)) return "";
  return "One FILE that is read may be -, standard input, and one that is written -, standard "
         "output: as .csv, or the first kind named for it where .csv is none of them. npy:- and so "
         "on name another kind; .hdf5 and .nhdr cannot be streams. Standard output is sent once it "
         "is complete, and the exit status tells whether all of it went through; what is printed "
         "goes to standard error.";
}

std::string HelpFormatter::make_help(const CLI::App* command, std::string name,
                                     CLI::AppFormatMode /*mode*/) const {
  std::string text = command->get_description() + "\n";
  text += "Usage: " + usage_of(*command, name) + "\n";
  const std::vector<OptionHelp> arguments = arguments_of(*command);
  if (!arguments.empty()) text += "\nArguments:\n";
  for (const OptionHelp& argument : arguments) text += entry(heading(argument), argument.text);
  const std::vector<const CLI::App*> commands = commands_of(*command);
  if (!commands.empty()) text += "\nCommands:\n";
  for (const CLI::App* const one : commands) text += entry(one->get_name(), one->get_description());
  for (const OptionGroup& group : option_groups(*command)) {
    text += "\n" + (commands.empty() ? group.title : std::string("Options")) + ":\n";
    for (const OptionHelp& option : group.options) text += entry(heading(option), option.text);
  }
  const std::string streams = streams_text(*command);
  if (!streams.empty()) text += "\nStandard streams:\n" + entry("", streams);
  if (!command->get_footer().empty()) text += "\n" + command->get_footer() + "\n";
  return text;
}

}  // namespace ccvt::cli
