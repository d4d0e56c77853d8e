#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <thread>

namespace ccvt::python {

/// call(), which takes the interpreter's lock or runs code of Python. When the interpreter ends
/// meanwhile, Python before 3.14 ends other threads there by unwinding their stacks, which neither
/// destructors nor the library's threads outlive. Such a thread sleeps instead, as it does
/// from 3.14 on, until the process is gone. What Python raises is no exception of C++: call()
/// throws nothing.
template <class Call>
auto outlive(const Call& call) noexcept {
  try {
    return call();
  } catch (...) {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
}

/// Without the interpreter's lock, from here to the end of the scope.
class Unlocked {
 public:
  Unlocked() : state_(PyEval_SaveThread()) {}
  Unlocked(const Unlocked&) = delete;
  ~Unlocked() { take_back(); }

 private:
  friend class Locked;
  void take_back() {
    outlive([&] { PyEval_RestoreThread(state_); });
  }

  PyThreadState* state_;
};

/// With the lock again, in a scope within that of `unlocked` and in the same thread.
class Locked {
 public:
  explicit Locked(Unlocked& unlocked) : unlocked_(unlocked) { unlocked_.take_back(); }
  Locked(const Locked&) = delete;
  ~Locked() { unlocked_.state_ = PyEval_SaveThread(); }

 private:
  Unlocked& unlocked_;
};

}  // namespace ccvt::python
