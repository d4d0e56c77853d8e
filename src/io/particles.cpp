#include "ccvt/particles.h"

#include <string>

#include "checks.h"
#include "io/formats.h"
#include "io/gadget.h"
#include "io/hdf5_particles.h"
#include "io/input_file.h"
#include "io/particle_load.h"
#include "number_text.h"

namespace ccvt {

namespace {

constexpr int kMostRepeats = 1000;

void check_range(const char* name, double value, bool good, const char* rule) {
  if (!good) throw InvalidInput(std::string(name) + ": " + text(value) + " is not " + rule);
}

void check_options(const ParticleOptions& options) {
  check_range("box_size", options.box_size, options.box_size >= 1e-30 && options.box_size <= 1e30,
              "from 1e-30 to 1e30");
  check_range("repeat", options.repeat, options.repeat >= 1 && options.repeat <= kMostRepeats,
              "from 1 to 1000");
  check_range("density", options.density, options.density > 0 && std::isfinite(options.density),
              "positive and finite");
  check_range("redshift", options.redshift,
              options.redshift >= 0 && std::isfinite(options.redshift), "at least 0 and finite");
  require_enumerator("type", options.type, ParticleType::dark_matter);
  check_range("gadget_format", options.gadget_format,
              options.gadget_format == 1 || options.gadget_format == 2, "1 or 2");
}

}  // namespace

std::uint64_t particle_count(Index sites, const ParticleOptions& options) {
  check_options(options);
  const auto repeat = static_cast<std::uint64_t>(options.repeat);
  return static_cast<std::uint64_t>(sites) * repeat * repeat * repeat;
}

double particle_mass(Index sites, const ParticleOptions& options) {
  const double side = options.box_size;
  return options.density * side * side * side / static_cast<double>(particle_count(sites, options));
}

void check_particles(const std::filesystem::path& path, Index sites, std::size_t scalar_bytes,
                     const ParticleOptions& options) {
  const std::string extension = io::extension_of(path);
  if (!io::is_among(io::kParticleFiles, extension)) {
    throw InvalidInput(path.string() + ": unknown extension " + io::quoted(extension) +
                       "; particles go into " + io::list_of(io::kParticleFiles, " or "));
  }
  if (sites < 1) throw InvalidInput("sites: there are none; at least one is needed");
  const double mass = particle_mass(sites, options);
  check_range("density", options.density, mass > 0 && std::isfinite(mass),
              "such that masses are positive and finite");
  if (extension == ".hdf5") return io::check_hdf5(path);
  io::check_gadget_size(path, particle_count(sites, options), scalar_bytes);
}

template <class Scalar>
void write_particles(const std::filesystem::path& path, PointsView<Scalar> sites,
                     const ParticleOptions& options) {
  check_particles(path, sites.count, sizeof(Scalar), options);
  require_data("sites", sites);
  const io::ParticleLoad load(sites, options);
  if (io::extension_of(path) == ".hdf5") return io::write_hdf5_particles(path, load);
  io::write_gadget<Scalar>(path, load);
}

template CCVT_EXPORT void write_particles<float>(const std::filesystem::path&, PointsView<float>,
                                                 const ParticleOptions&);
template CCVT_EXPORT void write_particles<double>(const std::filesystem::path&, PointsView<double>,
                                                  const ParticleOptions&);

namespace io {

template <class Scalar>
ParticleLoad::ParticleLoad(PointsView<Scalar> sites, const ParticleOptions& options)
    : options_(options),
      count_(particle_count(sites.count, options)),
      mass_(particle_mass(sites.count, options)),
      side_(options.box_size / options.repeat) {
  if (sites.dimension != 3) {
    throw InvalidInput("sites: have " + std::to_string(sites.dimension) +
                       " dimensions; particles have 3");
  }
  unit_.reserve(3 * static_cast<std::size_t>(sites.count));
  for (Index s = 0; s < sites.count; ++s) {
    for (int d = 0; d < 3; ++d) {
      const double x = sites[s][d];
      if (!(x >= 0 && x <= 1)) {
        throw InvalidInput("sites: coordinate " + std::to_string(d) + " of site " +
                           std::to_string(s) + " is " + text(x) + ", outside the unit cube");
      }
      unit_.push_back(x);
    }
  }
}

template ParticleLoad::ParticleLoad(PointsView<float>, const ParticleOptions&);
template ParticleLoad::ParticleLoad(PointsView<double>, const ParticleOptions&);

double ParticleLoad::spacing() const {
  return options_.box_size / std::cbrt(static_cast<double>(count_));
}

std::array<double, 3> ParticleLoad::corner_of(std::uint64_t tile) const {
  const auto repeat = static_cast<std::uint64_t>(options_.repeat);
  const std::uint64_t row = tile / repeat;
  const std::uint64_t layer = row / repeat;
  return {static_cast<double>(tile % repeat), static_cast<double>(row % repeat),
          static_cast<double>(layer)};
}

}  // namespace io
}  // namespace ccvt
