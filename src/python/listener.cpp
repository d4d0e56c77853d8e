#include "listener.h"

namespace ccvt::python {

std::function<bool(const IterationRecord&)> Listener::on_iteration() {
  return [this](const IterationRecord& record) { return hear(record); };
}

std::function<bool()> Listener::cancelled() {
  return [this] { return ask(); };
}

bool Listener::hear(const IterationRecord& record) {
  if (error_ || stopped_) return false;
  const Locked locked(*unlocked_);
  try {
    const py::tuple fields = tuple_of(record);
    const auto answer = py::reinterpret_steal<py::object>(
        outlive([&] { return PyObject_CallOneArg(progress_.ptr(), fields.ptr()); }));
    if (!answer) throw py::error_already_set();
    // Whatever is not False, of Python or of NumPy, goes on; None in particular.
    py::detail::make_caster<bool> truth;
    return answer.is_none() || !truth.load(answer, false) || static_cast<bool>(truth);
  } catch (const py::error_already_set&) {
    error_ = std::current_exception();
    return false;
  }
}

bool Listener::ask() {
  if (error_ || stopped_) return true;
  const Locked locked(*unlocked_);
  // A handler of signals may be what stops.
  if (outlive([] { return PyErr_CheckSignals(); }) == 0) return stopped_;
  error_ = std::make_exception_ptr(py::error_already_set());
  return true;
}

void Listener::rethrow() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

py::tuple tuple_of(const IterationRecord& record) {
  return py::make_tuple(record.iteration, record.level, record.levels, record.points, record.full,
                        record.pairs, record.swaps, record.exchanged, record.active_sites,
                        record.energy, record.seconds, record.progress);
}

}  // namespace ccvt::python
