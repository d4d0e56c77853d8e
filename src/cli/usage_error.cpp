#include "cli/usage_error.h"

#include <string_view>
#include <vector>

namespace ccvt::cli {

namespace {

/// `text` up to `end`, which it has.
std::string before(const std::string& text, std::string_view end) {
  return text.substr(0, text.find(end));
}

std::string commands_of(const CLI::App& app) {
  std::string list;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    list += (list.empty() ? "" : ", ") + command->get_name();
  }
  return list;
}

/// CLI11 keeps nothing of a mistake but its kind and an English sentence.
std::string reason(const CLI::App& app, const std::string& command, const CLI::ParseError& error) {
  std::string text = error.what();
  if (error.get_name() == "RequiredError") {
    if (command.empty()) return "needs a command, one of " + commands_of(app);
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
  const std::string command = given.empty() ? "" : given.front()->get_name();
  const std::vector<std::string> unknown = app.remaining(true);
  const auto what = [&] {
    if (unknown.empty()) return reason(app, command, error);
    const std::string& first = unknown.front();
    if (!command.empty() || first.starts_with("-")) return "unknown argument '" + first + "'";
    return "unknown command '" + first + "', not one of " + commands_of(app);
  };
  return what() + "; see ccvt " + (command.empty() ? "" : command + " ") + "--help";
}

}  // namespace ccvt::cli
