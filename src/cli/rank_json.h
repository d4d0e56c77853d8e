#pragma once

#include <nlohmann/json.hpp>

#include "cli/run.h"

namespace ccvt::cli {

/// As summaries have it.
inline nlohmann::ordered_json json_of(const RankFigures& ranks) {
  return {{"count", ranks.ranks},
          {"messages", ranks.messages},
          {"sent_bytes", ranks.sent_bytes},
          {"gathered_bytes", ranks.gathered_bytes},
          {"message_seconds", ranks.seconds},
          {"largest_peak_memory_bytes", ranks.largest_peak_bytes}};
}

}  // namespace ccvt::cli
