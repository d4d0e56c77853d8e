#include "cli/pages/completions.h"

#include <string_view>
#include <vector>

#include "cli/help.h"

namespace ccvt::cli {

namespace {

std::vector<OptionHelp> options_of(const CLI::App& command) {
  std::vector<OptionHelp> options;
  for (const OptionGroup& group : option_groups(command)) {
    options.insert(options.end(), group.options.begin(), group.options.end());
  }
  return options;
}

bool takes_file(const OptionHelp& option) {
  return option.value.find("FILE") != std::string::npos || option.value == "DIR" ||
         option.value == "HOW";
}

/// The names that an option can be given under, with blanks between them.
std::string names_of(const std::vector<OptionHelp>& options) {
  std::string names;
  for (const OptionHelp& option : options) {
    for (const std::string& name : option.names) names += (names.empty() ? "" : " ") + name;
  }
  return names;
}

std::string names_of_commands(const CLI::App& app) {
  std::string names;
  for (const CLI::App* const command : commands_of(app)) {
    names += (names.empty() ? "" : " ") + command->get_name();
  }
  return names;
}

/// `text` between single quotes, its first sentence or what comes before a default, with
/// `forbidden` letters as blanks.
std::string quoted(std::string_view text, std::string_view forbidden) {
  text = text.substr(0, text.find(" ["));
  text = text.substr(0, text.find(". "));
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      result += forbidden.find(c) == std::string_view::npos ? c : ' ';
    }
  }
  return result + "'";
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::string cases;
  std::string valued;
  for (const CLI::App* const command : commands_of(app)) {
    const std::vector<OptionHelp> options = options_of(*command);
    cases += "    " + command->get_name() + ") options='" + names_of(options) + "' ;;\n";
    for (const OptionHelp& option : options) {
      if (option.value.empty() || takes_file(option)) continue;
      for (const std::string& name : option.names) {
        const std::string entry = " " + name + " ";
        if ((valued + " ").find(entry) == std::string::npos) valued += " " + name;
      }
    }
  }
  return "# bash completion of ccvt\n"
         "_ccvt() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options=\n"
         "  case ${COMP_WORDS[1]} in\n" +
         cases + "    *) options='" + names_of(options_of(app)) +
         "' ;;\n"
         "  esac\n"
         "  COMPREPLY=()\n"
         "  if [ \"$COMP_CWORD\" -eq 1 ] && [ \"${word#-}\" = \"$word\" ]; then\n"
         "    COMPREPLY=($(compgen -W '" +
         names_of_commands(app) +
         "' -- \"$word\"))\n"
         "  elif [ \"${word#-}\" != \"$word\" ]; then\n"
         "    COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
         "  else\n"
         "    case \" " +
         valued.substr(1) +
         " \" in\n"
         "      *\" $before \"*) ;;  # a number or a word\n"
         "      *) compopt -o filenames; COMPREPLY=($(compgen -f -- \"$word\")) ;;\n"
         "    esac\n"
         "  fi\n"
         "}\n"
         "complete -F _ccvt ccvt\n";
}

std::string zsh_completion(const CLI::App& app) {
  constexpr std::string_view kForbidden = "[]:\n";
  std::string commands;
  std::string cases;
  for (const CLI::App* const command : commands_of(app)) {
    commands +=
        "    " + command->get_name() + ":" + quoted(command->get_description(), kForbidden) + "\n";
    cases += "    " + command->get_name() + ")\n      _arguments";
    for (const OptionHelp& option : options_of(*command)) {
      for (const std::string& name : option.names) {
        cases += " \\\n        '" + name + "['" + quoted(option.text, kForbidden) + "']" +
                 (option.value.empty() ? "" : ":" + option.value + ":") +
                 (takes_file(option) ? "_files" : "") + "'";
      }
    }
    cases += " \\\n        '*:file:_files' ;;\n";
  }
  return "#compdef ccvt\n"
         "local -a commands\n"
         "if (( CURRENT == 2 )); then\n"
         "  commands=(\n" +
         commands +
         "  )\n"
         "  _describe command commands\n"
         "else\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  (( CURRENT-- ))\n"
         "  case $command in\n" +
         cases +
         "  esac\n"
         "fi\n";
}

std::string fish_completion(const CLI::App& app) {
  const std::string none = "not __fish_seen_subcommand_from " + names_of_commands(app);
  std::string text = "# fish completion of ccvt\n";
  for (const CLI::App* const command : commands_of(app)) {
    text += "complete -c ccvt -f -n '" + none + "' -a " + command->get_name() + " -d " +
            quoted(command->get_description(), "\n") + "\n";
  }
  for (const CLI::App* const command : commands_of(app)) {
    for (const OptionHelp& option : options_of(*command)) {
      text += "complete -c ccvt -n '__fish_seen_subcommand_from " + command->get_name() + "'";
      for (const std::string& name : option.names) {
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      if (!option.value.empty()) text += takes_file(option) ? " -r -F" : " -x";
      text += " -d " + quoted(option.text, "\n") + "\n";
    }
  }
  return text;
}

}  // namespace ccvt::cli
