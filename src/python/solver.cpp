#include "ccvt/solver.h"

#include <pybind11/stl.h>

#include <atomic>
#include <memory>
#include <optional>
#include <stdexcept>

#include "arrays.h"
#include "bindings.h"
#include "ccvt/lloyd.h"
#include "ccvt/weighted.h"
#include "listener.h"
#include "lock.h"
#include "options.h"

namespace ccvt::python {

namespace {

/// What is given beside points and the number of sites.
struct Given {
  std::optional<py::array_t<Index>> capacities;
  std::optional<py::array_t<double>> box;
  std::vector<bool> along;
  std::optional<py::array> initial_sites;
  std::optional<py::array> fixed_sites;
  std::optional<py::array_t<Index>> initial_owners;

  explicit Given(const py::dict& given) {
    take(given, "capacities", capacities);
    take(given, "box", box);
    if (given.contains("along")) along = given["along"].cast<std::vector<bool>>();
    take(given, "initial_sites", initial_sites);
    take(given, "fixed_sites", fixed_sites);
    take(given, "initial_owners", initial_owners);
  }

 private:
  template <class Value>
  static void take(const py::dict& given, const char* key, std::optional<Value>& value) {
    if (given.contains(key)) value = given[key].cast<Value>();
  }
};

template <class Scalar>
Problem<Scalar> make_problem(PointsView<Scalar> points, Index sites, const Given& given,
                             int threads) {
  Problem<Scalar> problem = [&] {
    const Unlocked unlocked;
    return Problem<Scalar>(points, sites, threads);
  }();
  problem.set_domain(domain_of(given.box, given.along));
  if (given.capacities) problem.set_capacities(vector_of(*given.capacities));
  if (given.initial_sites) problem.set_initial_sites(columns_of<Scalar>(*given.initial_sites));
  if (given.fixed_sites) problem.set_fixed_sites(columns_of<Scalar>(*given.fixed_sites));
  if (given.initial_owners) problem.set_initial_owners(vector_of(*given.initial_owners));
  return problem;
}

/// A Solver of float or of double.
class AnySolver {
 public:
  AnySolver() = default;
  AnySolver(const AnySolver&) = delete;
  virtual ~AnySolver() = default;

  virtual bool step() = 0;
  virtual bool run() = 0;
  virtual void cancel() = 0;
  virtual py::array sites() = 0;
  virtual py::array owners() = 0;
  virtual py::dict summary() = 0;
  /// How many records there are, and the last of them.
  virtual std::size_t iterations() = 0;
  virtual py::tuple last() = 0;
};

template <class Scalar>
class SolverOf final : public AnySolver {
 public:
  SolverOf(py::array points, Index sites, const Given& given, const py::dict& options,
           py::object progress)
      : points_(std::move(points)), listener_(std::move(progress)) {
    Options made = options_from(options, {});
    listener_.listen_to(made);
    Problem<Scalar> problem = make_problem(view_of<Scalar>(points_), sites, given, made.threads);
    solver_ = listener_.run(
        [&] { return std::make_unique<Solver<Scalar>>(std::move(problem), std::move(made)); });
  }

  bool step() override {
    return work([&] { return solver_->step(); });
  }
  bool run() override {
    return work([&] {
      solver_->run();
      return true;
    });
  }
  void cancel() override {
    // First, so that a call which is at work hears of it.
    listener_.stop();
    if (busy_) return;
    const Use use(*this);
    solver_->cancel();  // with the lock: else calls of others would be refused meanwhile
  }
  py::array sites() override {
    const Use use(*this);
    return array_of(solver_->sites());
  }
  py::array owners() override {
    const Use use(*this);
    return array_of(solver_->owners());
  }
  py::dict summary() override {
    const Use use(*this);
    return dict_of(solver_->summary());
  }
  std::size_t iterations() override {
    const Use use(*this);
    return solver_->summary().iterations_log.size();
  }
  py::tuple last() override {
    const Use use(*this);
    return tuple_of(solver_->summary().iterations_log.back());
  }

 private:
  /// While the interpreter's lock is released, another thread, or the progress function, may try to
  /// use the solver too.
  class Use {
   public:
    explicit Use(SolverOf& solver) : solver_(solver) {
      if (!solver.busy_.exchange(true)) return;
      throw std::runtime_error(
          "Solver: is at work in another call; until that is over, there is only cancel()");
    }
    Use(const Use&) = delete;
    ~Use() { solver_.busy_ = false; }

   private:
    SolverOf& solver_;
  };

  /// call(), without the lock. After it cancel() counts, too, until others can tell that it is
  /// over.
  template <class Call>
  bool work(const Call& call) {
    const Use use(*this);
    const bool result = listener_.run(call);
    if (listener_.stopped()) solver_->cancel();
    return result;
  }

  py::array points_;  ///< what the solver looks at
  Listener listener_;
  std::unique_ptr<Solver<Scalar>> solver_;
  std::atomic<bool> busy_ = false;
};

std::unique_ptr<AnySolver> make_solver(const py::array& points, Index sites, const py::dict& given,
                                       const py::dict& options, const py::object& progress) {
  const Given rest(given);
  if (py::isinstance<py::array_t<float>>(points)) {
    return std::make_unique<SolverOf<float>>(points, sites, rest, options, progress);
  }
  return std::make_unique<SolverOf<double>>(points, sites, rest, options, progress);
}

py::tuple run_lloyd(const py::array& points, Index sites, const py::dict& given,
                    const py::dict& options, const py::object& progress) {
  const Given rest(given);
  Listener listener(progress);
  Options made = options_from(options, {});
  listener.listen_to(made);
  return visit_points(points, [&]<class Scalar>(PointsView<Scalar> view) {
    const Problem<Scalar> problem = make_problem(view, sites, rest, made.threads);
    const auto result = listener.run([&] { return lloyd(problem, made); });
    return py::make_tuple(array_of(result.sites), array_of(result.owners), dict_of(result.summary));
  });
}

MassMethod mass_method_from(const std::string& word) {
  for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
    if (word == to_string(method)) return method;
  }
  throw InvalidInput("method: is '" + word + "', but must be one of whole, resampled");
}

py::dict run_masses(const py::array& points, const py::array_t<double>& masses, Index sites,
                    const py::dict& given, const py::dict& options, const py::object& progress) {
  Listener listener(progress);
  MassOptions made;
  made.method = mass_method_from(given["method"].cast<std::string>());
  made.points_per_site = given["points_per_site"].cast<Index>();
  made.domain = domain_of(given["box"].cast<std::optional<py::array_t<double>>>(),
                          given["along"].cast<std::vector<bool>>());
  if (given.contains("capacities")) {
    made.capacities = vector_of(given["capacities"].cast<py::array_t<double>>());
  }
  made.relaxation = options_from(options, {});
  listener.listen_to(made.relaxation);
  return visit_points(points, [&](auto view) {
    const auto found =
        listener.run([&] { return tessellate_masses(view, span_of(masses), sites, made); });
    std::vector<Index> share_points;
    std::vector<Index> share_sites;
    std::vector<double> share_masses;
    for (const MassShare& share : found.shares) {
      share_points.push_back(share.point);
      share_sites.push_back(share.site);
      share_masses.push_back(share.mass);
    }
    py::dict result;
    result["sites"] = array_of(found.sites);
    result["owners"] = array_of(found.owners);
    result["masses"] = array_of(found.masses);
    result["capacities"] = array_of(found.capacities);
    result["largest_mass_error"] = found.largest_mass_error;
    result["mass_error_bound"] = found.mass_error_bound;
    result["share_points"] = array_of(share_points);
    result["share_sites"] = array_of(share_sites);
    result["share_masses"] = array_of(share_masses);
    result["summary"] = dict_of(found.summary);
    return result;
  });
}

}  // namespace

void bind_solver(py::module_& module) {
  py::class_<AnySolver> solver(module, "Solver");
  solver.def("step", &AnySolver::step)
      .def("run", &AnySolver::run)
      .def("cancel", &AnySolver::cancel)
      .def("sites", &AnySolver::sites)
      .def("owners", &AnySolver::owners)
      .def("summary", &AnySolver::summary)
      .def("iterations", &AnySolver::iterations)
      .def("last", &AnySolver::last);
  // Of this type there is what make_solver() gives: __new__() alone, as copy and pickle call it,
  // would leave an object without a solver.
  reinterpret_cast<PyTypeObject*>(solver.ptr())->tp_new = nullptr;
  module.def("make_solver", &make_solver);
  module.def("lloyd", &run_lloyd);
  module.def("tessellate_masses", &run_masses);
}

}  // namespace ccvt::python
