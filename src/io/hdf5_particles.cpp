#include "io/hdf5_particles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "io/hdf5_file.h"
#include "io/input_file.h"

namespace ccvt::io {

namespace {

constexpr double kSmoothing = 1.2348;  ///< smoothing length in mean spacings: 48 neighbours

void write_header(Hdf5Output& file, const ParticleLoad& load) {
  const Hdf5Handle header = file.group("Header");
  const auto flag = [&](const char* name, std::int32_t value) {
    file.attribute(header, name, value);
  };
  const auto real = [&](const char* name, double value) { file.attribute(header, name, value); };
  const std::uint64_t count = load.count();
  if (count <= std::numeric_limits<std::uint32_t>::max()) {
    const auto counts = load.by_type(static_cast<std::uint32_t>(count));
    file.attribute(header, "NumPart_ThisFile", counts);
    file.attribute(header, "NumPart_Total", counts);
  } else {
    file.attribute(header, "NumPart_ThisFile", load.by_type(count));
    file.attribute(header, "NumPart_Total", load.by_type(count));
  }
  file.attribute(header, "NumPart_Total_HighWord", load.by_type(std::uint32_t{0}));
  file.attribute(header, "MassTable", load.by_type(load.mass()));
  flag("NumFilesPerSnapshot", 1);
  flag("Dimension", 3);
  real("BoxSize", load.options().box_size);
  real("Time", 1 / (1 + load.options().redshift));
  real("Redshift", load.options().redshift);
  real("Omega0", 0);
  real("OmegaBaryon", 0);
  real("OmegaLambda", 0);
  real("HubbleParam", 1);
  flag("Flag_Cooling", 0);
  flag("Flag_DoublePrecision", 1);
  flag("Flag_Entropy_ICs", 0);
  flag("Flag_Feedback", 0);
  flag("Flag_Metals", 0);
  flag("Flag_Sfr", 0);
  flag("Flag_StellarAge", 0);
  file.attribute(file.group("RuntimePars"), "PeriodicBoundariesOn", std::int32_t{1});
}

void write_positions(Hdf5Output& file, const Hdf5Handle& group, const ParticleLoad& load) {
  const Hdf5Handle dataset = file.dataset(group, "Coordinates", {load.count(), 3}, 0.0);
  std::vector<double> xyz;
  for_blocks(load, [&](std::uint64_t first, std::size_t number) {
    xyz.resize(3 * number);
    load.positions(first, std::span(xyz));
    file.rows(dataset, first, 3, std::span<const double>(xyz));
  });
}

template <class Number>
void write_numbers(Hdf5Output& file, const Hdf5Handle& group, const ParticleLoad& load) {
  const Hdf5Handle dataset = file.dataset(group, "ParticleIDs", {load.count()}, Number{0});
  std::vector<Number> numbers;
  for_blocks(load, [&](std::uint64_t first, std::size_t number) {
    numbers.resize(number);
    std::iota(numbers.begin(), numbers.end(), static_cast<Number>(first + 1));
    file.rows(dataset, first, 0, std::span<const Number>(numbers));
  });
}

}  // namespace

bool has_hdf5() { return true; }

void check_hdf5(const std::filesystem::path&) {}

void write_hdf5_particles(const std::filesystem::path& path, const ParticleLoad& load) {
  Hdf5Output file(path);
  write_header(file, load);
  {
    const std::string name = "PartType" + std::to_string(load.type());
    const Hdf5Handle group = file.group(name.c_str());
    const std::uint64_t count = load.count();
    write_positions(file, group, load);
    if (count < std::numeric_limits<std::uint32_t>::max()) {
      write_numbers<std::uint32_t>(file, group, load);
    } else {
      write_numbers<std::uint64_t>(file, group, load);
    }
    file.dataset(group, "Velocities", {count, 3}, 0.0);
    file.dataset(group, "Masses", {count}, load.mass());
    if (load.options().type == ParticleType::gas) {
      file.dataset(group, "SmoothingLength", {count}, kSmoothing * load.spacing());
      file.dataset(group, "InternalEnergy", {count}, 0.0);
    }
  }
  file.commit();
}

namespace {

/// An open file and the coordinates of each type that it has particles of.
class Hdf5Input {
 public:
  explicit Hdf5Input(const std::filesystem::path& path) : plain_(path) {
    file_ = Hdf5Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (!file_) plain_.fail("is no HDF5 file, or a damaged one");
    header_ = Hdf5Handle(H5Gopen2(file_.id(), "Header", H5P_DEFAULT), H5Gclose);
    if (!header_) plain_.fail("has no group 'Header'");
    if (read_attribute("NumFilesPerSnapshot", 1).value_or(1) > 1) {
      plain_.fail("is one of several files; only all particles in one are supported");
    }
    points_.scalar = ScalarType::float32;
    points_.dimension = 3;
    for (int type = 0; type < 6; ++type) open_type(type);
    if (points_.count == 0) plain_.fail("has no dataset 'PartType*/Coordinates' with particles");
    read_box();
  }

  [[nodiscard]] const PointsHeader& points() const { return points_; }

  template <class Scalar>
  void read(PointsMap<Scalar> points) {
    Scalar* next = points.data();
    for (const Dataset& dataset : datasets_) {
      if (H5Dread(dataset.handle.id(), hdf5_type<Scalar>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, next) <
          0) {
        plain_.fail("its coordinates cannot be read: it is damaged or truncated");
      }
      next += 3 * dataset.count;
    }
  }

 private:
  struct Dataset {
    Hdf5Handle handle;
    std::uint64_t count;
  };

  /// `count` numbers of an attribute of the header; the first. Nothing when it has not as many.
  std::optional<double> read_attribute(const char* name, std::size_t count,
                                       std::vector<double>* values = nullptr) {
    if (H5Aexists(header_.id(), name) <= 0) return {};
    const Hdf5Handle attribute(H5Aopen(header_.id(), name, H5P_DEFAULT), H5Aclose);
    if (!attribute) return {};
    const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
    if (!space || H5Sget_simple_extent_npoints(space.id()) != static_cast<hssize_t>(count)) {
      return {};
    }
    std::vector<double> numbers(count);
    if (H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, numbers.data()) < 0) return {};
    if (values != nullptr) *values = numbers;
    return numbers.front();
  }

  void open_type(int type) {
    const std::string group = "PartType" + std::to_string(type);
    const std::string name = group + "/Coordinates";
    if (H5Lexists(file_.id(), group.c_str(), H5P_DEFAULT) <= 0) return;
    if (H5Lexists(file_.id(), name.c_str(), H5P_DEFAULT) <= 0) return;
    Hdf5Handle dataset(H5Dopen2(file_.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset) plain_.fail("'" + name + "' is no dataset");
    const Hdf5Handle space(H5Dget_space(dataset.id()), H5Sclose);
    std::array<hsize_t, 2> shape{};
    if (!space || H5Sget_simple_extent_ndims(space.id()) != 2 ||
        H5Sget_simple_extent_dims(space.id(), shape.data(), nullptr) != 2 || shape[1] != 3) {
      plain_.fail("'" + name + "' is not of shape (#particles, 3)");
    }
    const Hdf5Handle stored(H5Dget_type(dataset.id()), H5Tclose);
    if (!stored || H5Tget_class(stored.id()) != H5T_FLOAT) {
      plain_.fail("'" + name + "' holds no real numbers");
    }
    if (H5Tget_size(stored.id()) > sizeof(float)) points_.scalar = ScalarType::float64;
    if (shape[0] == 0) return;
    require_values(dataset, name);
    constexpr std::uint64_t most = std::numeric_limits<Index>::max();
    if (shape[0] > most - points_.count) {
      plain_.fail("has " + std::to_string(shape[0]) + " particles in '" + name + "' and " +
                  std::to_string(points_.count) + " before; at most 2147483647 are supported");
    }
    points_.count += shape[0];
    datasets_.push_back({std::move(dataset), shape[0]});
  }

  /// A shape that nothing has been written for may be of any size; those of a virtual dataset are
  /// in other files.
  void require_values(const Hdf5Handle& dataset, const std::string& name) {
    const Hdf5Handle properties(H5Dget_create_plist(dataset.id()), H5Pclose);
    H5D_space_status_t status = H5D_SPACE_STATUS_NOT_ALLOCATED;
    const bool known = properties && H5Dget_space_status(dataset.id(), &status) >= 0;
    const bool elsewhere = known && H5Pget_layout(properties.id()) == H5D_VIRTUAL;
    if (!known || (status == H5D_SPACE_STATUS_NOT_ALLOCATED && !elsewhere)) {
      plain_.fail("'" + name + "' has a shape, but no values were ever written");
    }
  }

  void read_box() {
    std::vector<double> box;
    if (!read_attribute("BoxSize", 3, &box)) {
      if (const auto side = read_attribute("BoxSize", 1)) box.assign(3, *side);
    }
    const bool good = std::all_of(box.begin(), box.end(),
                                  [](double side) { return side > 0 && std::isfinite(side); });
    if (good) points_.box = box;
  }

  Hdf5Session session_;
  InputFile plain_;  ///< for what it checks and says
  Hdf5Handle file_;
  Hdf5Handle header_;
  std::vector<Dataset> datasets_;
  PointsHeader points_;
};

}  // namespace

PointsHeader inspect_hdf5_points(const std::filesystem::path& path) {
  return Hdf5Input(path).points();
}

template <class Scalar>
PointsMap<Scalar> read_hdf5_points(const std::filesystem::path& path,
                                   const detail::Allocation<Scalar>& allocation) {
  Hdf5Input input(path);
  PointsMap<Scalar> points = allocate(allocation, input.points());
  input.read(points);
  return points;
}

template PointsMap<float> read_hdf5_points(const std::filesystem::path&,
                                           const detail::Allocation<float>&);
template PointsMap<double> read_hdf5_points(const std::filesystem::path&,
                                            const detail::Allocation<double>&);

}  // namespace ccvt::io
