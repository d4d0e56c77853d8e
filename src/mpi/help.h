#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace ccvt::mpi {

/// Makes the help of ccvt's commands that of ccvt-mpi: what is for ccvt only is left out, and
/// refused; kinds of files are those that several processes read and write, and examples begin with
/// mpirun.
void fit_help(CLI::App& app);

/// Throws InvalidInput where `word`, if there is one, is a command that only ccvt has.
void require_command(const CLI::App& app, const std::string& word);

}  // namespace ccvt::mpi
