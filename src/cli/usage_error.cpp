#include "cli/usage_error.h"

#include <string_view>
#include <vector>

#include "cli/help.h"
#include "cli/suggestion.h"

namespace ccvt::cli {

namespace {

/// `text` up to `end`, which it has.
std::string before(const std::string& text, std::string_view end) {
  return text.substr(0, text.find(end));
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* const command : commands_of(app)) names.push_back(command->get_name());
  return names;
}

std::string list_of_commands(const CLI::App& app) {
  std::string list;
  for (const std::string& name : names_of_commands(app)) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const OptionGroup& group : option_groups(command)) {
    for (const OptionHelp& option : group.options) {
      names.insert(names.end(), option.names.begin(), option.names.end());
    }
  }
  return names;
}

/// What was typed instead of an option or a command, and what is likely to have been meant.
std::string unknown_word(const CLI::App& app, const CLI::App* command, const std::string& word) {
  if (word == "--") return "what follows '--' is taken for files; options go before it";
  const bool option = word.starts_with("-");
  const std::string typed = before(word, "=");
  const std::string meant =
      likely_meant(typed, option ? names_of_options(command == nullptr ? app : *command)
                                 : names_of_commands(app));
  if (command != nullptr && option && meant == typed) {
    return "'" + typed + "' is out of place: options stand behind the command, and before any '--'";
  }
  std::string text = "unknown argument '" + word + "'";
  if (command == nullptr && !option) {
    text = "unknown command '" + word + "'";
    if (meant.empty()) text += ", not one of " + list_of_commands(app);
  }
  const bool helps = !meant.empty() && (option || command == nullptr);
  return text + (helps ? "; did you mean " + meant + "?" : "");
}

/// CLI11 keeps nothing of a mistake but its kind and an English sentence.
std::string reason(const CLI::App& app, const std::string& command, const CLI::ParseError& error) {
  std::string text = error.what();
  if (error.get_name() == "RequiredError") {
    if (command.empty()) return "needs a command, one of " + list_of_commands(app);
    return command + ": needs " + before(text, " is required");
  }
  if (error.get_name() == "ArgumentMismatch") {
    if (text.ends_with(" missing")) return before(text, ":") + ": needs a value";
    if (text.find("At Most") != std::string::npos) {
      return before(text, ":") + ": is given more than once";
    }
    // Of flags the name comes without its dashes.
    const std::string flag = before(text, " was given");
    if (flag != text) return (flag.size() == 1 ? "-" : "--") + flag + ": takes no value";
  }
  if (error.get_name() == "ExcludesError") {
    const std::string first = before(text, " excludes ");
    return first + ": cannot be given beside " + text.substr(first.size() + 10);
  }
  return text;
}

}  // namespace

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  const CLI::App* const command = given.empty() ? nullptr : given.front();
  const std::string name = command == nullptr ? "" : command->get_name();
  const std::vector<std::string> unknown = app.remaining(true);
  // A value that is not allowed may be the next option, whose own value is unknown then.
  const bool known = unknown.empty() || error.get_name() == "ValidationError";
  const std::string what =
      known ? reason(app, name, error) : unknown_word(app, command, unknown.front());
  return what + (what.ends_with("?") ? " See" : "; see") + " " + app.get_name() + " " +
         (name.empty() ? "" : name + " ") + "--help";
}

}  // namespace ccvt::cli
