#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ccvt/ranks.h"
#include "support/message.h"

/// Ranks that are threads of this process, for tests.
class ThreadRanks {
 public:
  explicit ThreadRanks(int count) : count_(count), boxes_(static_cast<std::size_t>(count)) {}

  /// Calls work(ranks) on each, at the same time.
  void run(const std::function<void(ccvt::Ranks&)>& work) {
    std::vector<std::thread> threads;
    for (int r = 0; r < count_; ++r) {
      threads.emplace_back([this, r, &work] {
        One one(*this, r);
        work(one);
      });
    }
    for (std::thread& thread : threads) thread.join();
  }

  /// How often messages were let get on, on all.
  [[nodiscard]] std::int64_t progressed() const { return progressed_; }

 private:
  using Bytes = ccvt::Ranks::Bytes;

  class One final : public ccvt::Ranks, public ccvt::MessageProgress {
   public:
    One(ThreadRanks& all, int rank) : all_(all), rank_(rank) {}
    [[nodiscard]] int rank() const override { return rank_; }
    [[nodiscard]] int count() const override { return all_.count_; }
    [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> own) override {
      return exchange(
          std::vector<Bytes>(static_cast<std::size_t>(count()), Bytes(own.begin(), own.end())));
    }
    [[nodiscard]] std::vector<Bytes> exchange(std::vector<Bytes> to) override {
      for (int r = 0; r < count(); ++r) put(r, -1, std::move(to[static_cast<std::size_t>(r)]));
      std::vector<Bytes> come;
      for (int r = 0; r < count(); ++r) come.push_back(take(r, -1));
      return come;
    }
    void send(int to, Bytes message) override { put(to, 0, std::move(message)); }
    [[nodiscard]] Bytes receive(int from) override { return take(from, 0); }
    [[nodiscard]] bool has_come(int from) override {
      const std::lock_guard lock(all_.mutex_);
      return !all_.boxes_[static_cast<std::size_t>(rank_)][{from, 0}].empty();
    }
    void progress() noexcept override { ++all_.progressed_; }

   private:
    void put(int to, int kind, Bytes message) {
      const std::lock_guard lock(all_.mutex_);
      all_.boxes_[static_cast<std::size_t>(to)][{rank_, kind}].push_back(std::move(message));
      all_.come_.notify_all();
    }
    Bytes take(int from, int kind) {
      std::unique_lock lock(all_.mutex_);
      auto& box = all_.boxes_[static_cast<std::size_t>(rank_)][{from, kind}];
      all_.come_.wait(lock, [&] { return !box.empty(); });
      Bytes message = std::move(box.front());
      box.pop_front();
      return message;
    }

    ThreadRanks& all_;
    int rank_;
  };

  int count_;
  std::atomic<std::int64_t> progressed_ = 0;
  std::mutex mutex_;
  std::condition_variable come_;
  /// Of each rank, by the one that sent them and their kind.
  std::vector<std::map<std::pair<int, int>, std::deque<Bytes>>> boxes_;
};

namespace ccvt::test {

/// What all ranks throw: one text, where it is the same.
inline std::set<std::string> messages_of(int count, const std::function<void(ccvt::Ranks&)>& work) {
  std::set<std::string> messages;
  std::mutex mutex;
  ThreadRanks(count).run([&](ccvt::Ranks& ranks) {
    const std::string message = message_of([&] { work(ranks); });
    const std::lock_guard lock(mutex);
    messages.insert(message);
  });
  return messages;
}

}  // namespace ccvt::test
