// Writes manual pages, and completions for three shells, into the directory that it is given: in
// man1 and in completions.

#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>

#include "cli/command_line.h"
#include "cli/pages/completions.h"
#include "cli/pages/manual.h"
#include "cli/pages/page_file.h"

namespace {

void write_pages(const std::filesystem::path& directory) {
  const ccvt::cli::CommandLine line;
  const CLI::App& app = line.app();
  ccvt::cli::write_manual(app, directory / "man1");
  using ccvt::cli::write_page;
  write_page(directory / "completions" / "ccvt.bash", ccvt::cli::bash_completion(app));
  write_page(directory / "completions" / "_ccvt", ccvt::cli::zsh_completion(app));
  write_page(directory / "completions" / "ccvt.fish", ccvt::cli::fish_completion(app));
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
