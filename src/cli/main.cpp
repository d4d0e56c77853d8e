#include <exception>
#include <new>
#include <string>

#include "ccvt/metrics.h"
#include "cli/command_line.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/streams.h"

namespace {

int report(const std::string& message, int status) {
  ccvt::cli::tell("error: " + message);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    ccvt::cli::fill_closed_streams();
    ccvt::cli::handle_signals();
    return ccvt::cli::CommandLine().run(argc, argv);
  } catch (const ccvt::InvalidInput& error) {
    return report(error.what(), 2);
  } catch (const ccvt::Cancelled&) {
    if (!ccvt::cli::interrupted()) {
      return report("the time limit came before there was anything to write", 1);
    }
    return report("interrupted before there was anything to write", 130);
  } catch (const std::bad_alloc&) {
    return report("out of memory", 1);
  } catch (const std::exception& error) {
    return report(error.what(), 1);
  } catch (...) {
    return report("unknown failure", 1);
  }
}
