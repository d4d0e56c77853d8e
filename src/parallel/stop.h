#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

namespace ccvt {

/// What a run that was cancelled may take to end properly: to give owners to points that have none,
/// or for an exact assignment.
constexpr std::chrono::milliseconds kTimeToFinish{300};

/// Thrown by Stop::check(), up to where it is known how a run ends that its caller has cancelled.
struct Stopped {};

/// Whether the caller of a long function wants it to end: the one way in which loops hear of it.
/// An Arena carries it, and checks it before each range of items; loops that are not the arena's
/// call check() themselves, often enough for tenths of a second.
///
/// The caller's callback is asked on the thread that called only, here at most every 20 ms; on
/// other threads, and once it has said yes, check() looks at a flag.
class Stop {
 public:
  Stop() = default;
  /// An empty callback never says yes. `seconds`: after so many it is as if it did; 0: never.
  explicit Stop(std::function<bool()> cancelled, double seconds = 0)
      : cancelled_(std::move(cancelled)), asking_(cancelled_ || seconds > 0) {
    constexpr double kLongest = 1e9;  // beyond, the clock has no such time
    if (seconds > 0 && seconds < kLongest) {
      deadline_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                     std::chrono::duration<double>(seconds));
    }
  }

  /// Makes this thread the one that asks.
  void enter() { caller_ = std::this_thread::get_id(); }

  /// Asks at once.
  bool requested() {
    if (!asking_ || stop_) return stop_;
    const auto now = Clock::now();
    if (!wished_) {
      late_ = now >= deadline_;
      if (late_ || asked()) wished_ = true;
      latest_ = now + patience_;
    }
    if (wished_ && now >= latest_) stop_ = true;
    return stop_;
  }
  /// Gives the caller so much time, from when he is told, to come to where he would rather end.
  void be_patient(std::chrono::milliseconds time) { patience_ = time; }
  /// Asks at once; true also while there is time left.
  bool wished() {
    requested();
    return wished_;
  }
  /// Whether the callback is being asked: whatever called check() is half done.
  [[nodiscard]] bool asks() const { return asks_; }
  /// Of the callback while it is asked: whatever it says, it has said yes.
  void wish() { wished_ = true; }
  /// Whether it was the time that ended it.
  [[nodiscard]] bool late() const { return late_; }

  void check() {
    if (stop_.load(std::memory_order_relaxed)) throw Stopped();
    if ((!asking_ && !limited_) || std::this_thread::get_id() != caller_) return;
    const auto now = Clock::now();
    if (now < next_) return;
    next_ = now + kInterval;
    if (limited_ || requested()) {
      stop_ = true;
      throw Stopped();
    }
  }

  /// Keeps check() from asking and throwing in what must not be left half done, and is short.
  class Pause {
   public:
    explicit Pause(Stop& stop)
        : stop_(stop),
          asking_(std::exchange(stop.asking_, false)),
          limited_(std::exchange(stop.limited_, false)),
          stopped_(stop.stop_.exchange(false)) {}
    ~Pause() {
      stop_.stop_ = stopped_;
      stop_.asking_ = asking_;
      stop_.limited_ = limited_;
    }
    Pause(const Pause&) = delete;
    Pause& operator=(const Pause&) = delete;

   private:
    Stop& stop_;
    bool asking_;
    bool limited_;
    bool stopped_;
  };

  /// So much more patience, with a wish that comes while this lives, in what had better be done to
  /// its end. When it is over, the caller has waited long enough.
  class Patience {
   public:
    Patience(Stop& stop, std::chrono::milliseconds more)
        : stop_(stop), more_(stop.wished_ ? std::chrono::milliseconds(0) : more) {
      stop_.patience_ += more_;
    }
    ~Patience() {
      stop_.patience_ -= more_;
      if (stop_.wished_) stop_.latest_ -= more_;
    }
    Patience(const Patience&) = delete;
    Patience& operator=(const Patience&) = delete;

   private:
    Stop& stop_;
    std::chrono::milliseconds more_;
  };

  /// The callback is not asked again, and check() throws no more.
  void off() {
    asking_ = limited_ = false;
    stop_ = false;
  }
  /// The callback is not asked again; check() throws when so much time has passed from now on.
  void allow(std::chrono::milliseconds time) {
    off();
    limited_ = true;
    next_ = Clock::now() + time;
  }

 private:
  bool asked() {
    if (!cancelled_) return false;
    struct Asking {
      bool& asks;
      explicit Asking(bool& flag) : asks(flag) { asks = true; }
      ~Asking() { asks = false; }
      Asking(const Asking&) = delete;
      Asking& operator=(const Asking&) = delete;
    } const asking(asks_);
    return cancelled_();
  }

  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kInterval{20};

  std::function<bool()> cancelled_;
  std::thread::id caller_ = std::this_thread::get_id();
  std::atomic<bool> stop_{false};
  // Of the caller's thread, or changed while no other works:
  Clock::time_point deadline_ = Clock::time_point::max();
  Clock::time_point latest_ = {};
  std::chrono::milliseconds patience_{0};
  bool wished_ = false;
  bool asks_ = false;
  bool late_ = false;
  bool asking_ = false;
  bool limited_ = false;
  Clock::time_point next_ = {};  // the first check asks
};

}  // namespace ccvt
