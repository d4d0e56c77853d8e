#pragma once

#include <filesystem>
#include <vector>

namespace ccvt::cli {

/// From now on the first Ctrl-C (SIGINT) makes interrupted() true; the second one removes
/// unfinished outputs and ends the program with status 130. SIGTERM and SIGHUP end it at once,
/// without leaving unfinished outputs either; a SIGHUP that is ignored stays so. SIGINT is handled
/// even where it was ignored, as shells have it for the background jobs of scripts.
void handle_signals();

[[nodiscard]] bool interrupted();

/// Names the outputs whose temporary files are to be removed on a sudden end. At most 5.
void protect_outputs(const std::vector<std::filesystem::path>& outputs);

}  // namespace ccvt::cli
