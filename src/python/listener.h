#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <exception>
#include <functional>
#include <utility>

#include "ccvt/summary.h"
#include "lock.h"

namespace ccvt::python {

namespace py = pybind11;

/// What Python has to say while the library computes without the interpreter's lock: the progress
/// function of a run, and signals such as Ctrl-C. An exception of either ends the run, and
/// rethrow() passes it on when the library has returned. To be made and destroyed with the lock.
class Listener {
 public:
  /// `progress`: None, or called with a tuple of the fields of IterationRecord; False stops.
  explicit Listener(py::object progress) : progress_(std::move(progress)) {}
  Listener(const Listener&) = delete;

  /// For Options::on_iteration and Options::cancelled, which are called within run(). They must not
  /// outlive this object.
  [[nodiscard]] std::function<bool(const IterationRecord&)> on_iteration();
  [[nodiscard]] std::function<bool()> cancelled();

  /// Gives options both.
  template <class SomeOptions>
  void listen_to(SomeOptions& options) {
    if (!progress_.is_none()) options.on_iteration = on_iteration();
    options.cancelled = cancelled();
  }

  /// From any thread: what asks, now or later, is told to stop.
  void stop() { stopped_ = true; }
  [[nodiscard]] bool stopped() const { return stopped_; }

  /// With the lock.
  void rethrow();

  /// Calls work() without the lock, and then passes on what Python threw meanwhile, in favour of
  /// what the library makes of it.
  template <class Work>
  auto run(const Work& work) {
    try {
      auto result = [&] {
        Unlocked unlocked;
        unlocked_ = &unlocked;
        return work();
      }();
      rethrow();
      return result;
    } catch (const Cancelled&) {
      rethrow();
      throw;
    }
  }

 private:
  bool hear(const IterationRecord& record);
  bool ask();

  py::object progress_;
  Unlocked* unlocked_ = nullptr;
  std::exception_ptr error_;
  std::atomic<bool> stopped_ = false;
};

/// The fields of a record, in the order of `Iteration` in _records.py.
py::tuple tuple_of(const IterationRecord& record);

}  // namespace ccvt::python
