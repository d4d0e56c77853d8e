#pragma once

#include <string>

#include "ccvt/types.h"

namespace ccvt::test {

/// What the InvalidInput says that `call` throws.
template <class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "nothing thrown";
}

}  // namespace ccvt::test
