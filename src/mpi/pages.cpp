// Writes the manual pages of ccvt-mpi into the directory that it is given.

#include <exception>
#include <iostream>
#include <stdexcept>

#include "cli/pages/manual.h"
#include "cli/standard_streams.h"
#include "command_line.h"

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("usage: ccvt_mpi_pages DIRECTORY");
    ccvt::cli::refuse_streams("ccvt-mpi");
    ccvt::cli::write_manual(ccvt::mpi::CommandLine().app, argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
