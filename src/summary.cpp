#include "ccvt/summary.h"

#include "number_text.h"

namespace ccvt {
namespace {

const char* why_not_normalized(const Summary& summary) {
  if (summary.normal_dimensions > 0) return " (not normalized: normals are dimensions)";
  // Before there is a result, nothing is known of it.
  if (summary.termination == Termination::running) return "";
  return " (not normalized: the domain has no volume)";
}

/// "normalized energy 0.17, ": what compares; nothing when energies are of normals as well.
std::string energy_text(const Summary& summary) {
  if (summary.normal_dimensions > 0) return "";
  return (summary.has_normalized_energy()
              ? "normalized energy " + text(summary.normalized_energy, 6)
              : "energy " + text(summary.energy, 6) + why_not_normalized(summary)) +
         ", ";
}

}  // namespace

const char* to_string(Termination termination) {
  switch (termination) {
    case Termination::running:
      return "running";
    case Termination::stable:
      return "stable";
    case Termination::blue_noise:
      return "blue_noise";
    case Termination::energy_tolerance:
      return "energy_tolerance";
    case Termination::iteration_limit:
      return "iteration_limit";
    case Termination::time_limit:
      return "time_limit";
    case Termination::cancelled:
      return "cancelled";
  }
  return "unknown";
}

bool Summary::has_normalized_energy() const {
  return normal_dimensions == 0 && (normalized_energy > 0 || !(energy > 0));
}

std::string Summary::brief() const {
  return std::string(to_string(termination)) + " after " + std::to_string(iterations) +
         " iterations: " + std::to_string(points) + " points, " + std::to_string(sites) +
         " sites, " + energy_text(*this) + text(seconds_total, 3) + " s";
}

std::string Summary::full() const {
  std::string out;
  const auto row = [&out](const std::string& name, const std::string& value) {
    out += name + std::string(name.size() < 24 ? 24 - name.size() : 1, ' ') + value + "\n";
  };
  row("termination", to_string(termination));
  row("dimension", std::to_string(dimension));
  row("points", std::to_string(points));
  row("sites", std::to_string(sites));
  row("seed", std::to_string(seed));
  row("threads", std::to_string(threads_used) + " (given: " + std::to_string(threads_given) + ")");
  row("initialization", initialization_used);
  row("levels", std::to_string(levels));
  row("iterations", std::to_string(iterations));
  row("pairs examined", std::to_string(pairs));
  row("swaps", std::to_string(swaps));
  row("points exchanged", std::to_string(exchanged));
  row("initial energy", text(initial_energy, 9));
  row("energy", text(energy, 9));
  row("normalized energy", has_normalized_energy()
                               ? text(normalized_energy, 6)
                               : std::string("n/a") + why_not_normalized(*this));
  row("capacity error", text(capacity_error, 6));
  row("seconds", text(seconds_total, 4));
  row("  initialization", text(seconds_initialization, 4));
  row("  relaxation", text(seconds_relaxation, 4));
  for (const PhaseRecord& phase : phases) {
    if (phase.seconds < seconds_total / 1000) continue;
    row("    " + phase.name, text(phase.seconds, 4) + " (" + text(phase.work_seconds, 4) + " in " +
                                 std::to_string(phase.tasks) + " tasks)");
  }
  return out;
}

}  // namespace ccvt
