#pragma once

#include <string>

#include "ccvt/io.h"
#include "ccvt/types.h"

namespace ccvt::test {

/// What the InvalidInput says that `call` throws, or the IoError, which is called by its name.
template <class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  } catch (const IoError& error) {
    return std::string("IoError: ") + error.what();
  }
  return "nothing thrown";
}

}  // namespace ccvt::test
