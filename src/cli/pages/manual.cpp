#include "cli/pages/manual.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "ccvt/version.h"
#include "cli/help.h"
#include "cli/pages/page_file.h"

namespace ccvt::cli {

namespace {

/// Text as roff takes it: no escapes, no line that begins a request, hyphens that can be copied.
std::string escaped(const std::string& text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    line_begins = c == '\n';
  }
  return result;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string bold(const std::string& text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string slanted(const std::string& text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string tagged(const std::string& tag, const std::string& text) {
  return ".TP\n" + tag + "\n" + escaped(text) + "\n";
}

std::string option_text(const OptionHelp& option) {
  std::string tag;
  for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + bold(name);
  if (!option.value.empty()) tag += " " + slanted(option.value) + (option.several ? " ..." : "");
  return tagged(tag, option.text + (option.required ? " (required)" : ""));
}

std::string argument_text(const OptionHelp& argument) {
  return tagged(slanted(argument.longest()) + (argument.several ? " ..." : ""), argument.text);
}

/// The examples as they stand.
std::string footer_text(const CLI::App& command) {
  const std::string footer = command.get_footer();
  const std::size_t end = std::min(footer.find("\n\n"), footer.size());
  const std::size_t begin = footer.find_first_not_of(" \n", footer.find(':') + 1);
  std::string text = ".SH EXAMPLES\n.nf\n" + escaped(footer.substr(begin, end - begin)) + "\n.fi\n";
  if (end < footer.size()) text += ".SH NOTES\n" + escaped(footer.substr(end + 2)) + "\n";
  return text;
}

/// Of the whole program (`command` empty), or of one command.
std::string manual_page(const CLI::App& app, const CLI::App* command) {
  const CLI::App& shown = command == nullptr ? app : *command;
  const std::string& program = app.get_name();
  const std::string name = command == nullptr ? program : program + "-" + command->get_name();
  const std::string line = command == nullptr ? program : program + " " + command->get_name();
  std::string page = ".TH " + upper(name) + " 1 \"\" \"ccvt " CCVT_VERSION "\" \"ccvt\"\n";
  page += ".SH NAME\n" + escaped(name) + " \\- " + escaped(shown.get_description()) + "\n";
  page += ".SH SYNOPSIS\n" + escaped(usage_of(shown, line)) + "\n";
  const std::vector<OptionHelp> arguments = arguments_of(shown);
  if (!arguments.empty()) page += ".SH ARGUMENTS\n";
  for (const OptionHelp& argument : arguments) page += argument_text(argument);
  const std::vector<const CLI::App*> commands = commands_of(shown);
  if (!commands.empty()) page += ".SH COMMANDS\n";
  for (const CLI::App* const one : commands) {
    page += tagged(bold(one->get_name()),
                   one->get_description() + ": see " + program + "-" + one->get_name() + "(1)");
  }
  page += ".SH OPTIONS\n";
  for (const OptionGroup& group : option_groups(shown)) {
    if (commands.empty()) page += ".SS " + group.title + "\n";
    for (const OptionHelp& option : group.options) page += option_text(option);
  }
  const std::string streams = streams_text(shown);
  if (!streams.empty()) page += ".SH STANDARD STREAMS\n" + escaped(streams) + "\n";
  page += footer_text(shown);
  if (command != nullptr) page += ".SH SEE ALSO\n.BR " + escaped(program) + " (1)\n";
  return page;
}

}  // namespace

void write_manual(const CLI::App& app, const std::filesystem::path& directory) {
  write_page(directory / (app.get_name() + ".1"), manual_page(app, nullptr));
  for (const CLI::App* const command : commands_of(app)) {
    write_page(directory / (app.get_name() + "-" + command->get_name() + ".1"),
               manual_page(app, command));
  }
}

}  // namespace ccvt::cli
