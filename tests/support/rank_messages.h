#pragma once

#include <functional>
#include <mutex>
#include <set>
#include <string>

#include "support/message.h"
#include "support/thread_ranks.h"

namespace ccvt::test {

/// What ranks throw: one message, if it is the same on all.
inline std::set<std::string> messages_on_ranks(int count, const std::function<void(Ranks&)>& work) {
  std::set<std::string> messages;
  std::mutex mutex;
  ThreadRanks(count).run([&](Ranks& ranks) {
    const std::string message = message_of([&] { work(ranks); });
    const std::lock_guard lock(mutex);
    messages.insert(message);
  });
  return messages;
}

}  // namespace ccvt::test
