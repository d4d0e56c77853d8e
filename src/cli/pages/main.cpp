// Writes manual pages, and completions for three shells, into the directory that it is given: in
// man1 and in completions.

#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "cli/command_line.h"
#include "cli/help.h"
#include "cli/pages/completions.h"
#include "cli/pages/manual.h"

namespace {

void write(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

void write_pages(const std::filesystem::path& directory) {
  const ccvt::cli::CommandLine line;
  const CLI::App& app = line.app();
  write(directory / "man1" / "ccvt.1", ccvt::cli::manual_page(app, nullptr));
  for (const CLI::App* const command : ccvt::cli::commands_of(app)) {
    write(directory / "man1" / ("ccvt-" + command->get_name() + ".1"),
          ccvt::cli::manual_page(app, command));
  }
  write(directory / "completions" / "ccvt.bash", ccvt::cli::bash_completion(app));
  write(directory / "completions" / "_ccvt", ccvt::cli::zsh_completion(app));
  write(directory / "completions" / "ccvt.fish", ccvt::cli::fish_completion(app));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("usage: ccvt_pages DIRECTORY");
    write_pages(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
