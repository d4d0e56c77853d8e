// What a user may do with every public header, printed as bits: the same whatever flags this file
// and the library were compiled with. See flags.sh.
#include <ccvt/capacity.h>
#include <ccvt/ccvt.h>
#include <ccvt/codebook.h>
#include <ccvt/columns.h>
#include <ccvt/density.h>
#include <ccvt/domain.h>
#include <ccvt/io.h>
#include <ccvt/lloyd.h>
#include <ccvt/metrics.h>
#include <ccvt/options.h>
#include <ccvt/particles.h>
#include <ccvt/point_cloud.h>
#include <ccvt/presets.h>
#include <ccvt/problem.h>
#include <ccvt/publication.h>
#include <ccvt/sampling.h>
#include <ccvt/solver.h>
#include <ccvt/stipple.h>
#include <ccvt/summary.h>
#include <ccvt/tessellation.h>
#include <ccvt/thin.h>
#include <ccvt/types.h>
#include <ccvt/version.h>
#include <ccvt/volume.h>
#include <ccvt/weighted.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace {

/// FNV-1a over the bits of all that is put in; no arithmetic that flags could change.
class Bits {
 public:
  Bits& operator<<(double value) { return bytes(&value, sizeof value); }
  Bits& operator<<(const std::string& text) { return bytes(text.data(), text.size()); }
  template <class Number>
  Bits& operator<<(const std::vector<Number>& values) {
    return bytes(values.data(), values.size() * sizeof(Number));
  }
  template <class Scalar>
  Bits& operator<<(const ccvt::Columns<Scalar>& values) {
    return bytes(values.data(), static_cast<std::size_t>(values.size()) * sizeof(Scalar));
  }
  template <class Derived>
  Bits& operator<<(const Eigen::PlainObjectBase<Derived>& values) {
    return bytes(values.data(),
                 static_cast<std::size_t>(values.size()) * sizeof(typename Derived::Scalar));
  }
  void print(const char* what) const {
    std::printf("%-12s %016llx\n", what, static_cast<unsigned long long>(hash_));
  }

 private:
  Bits& bytes(const void* data, std::size_t count) {
    const auto* const byte = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < count; ++i) hash_ = (hash_ ^ byte[i]) * 0x100000001b3ULL;
    return *this;
  }
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

/// Multiples of 2^-16 in [0, 1): exact in float, so that no flag rounds them otherwise.
template <class Matrix>
Matrix made_up(Eigen::Index rows, Eigen::Index cols, std::uint32_t seed) {
  Matrix m(rows, cols);
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    seed = seed * 1664525U + 1013904223U;
    m.data()[i] = static_cast<typename Matrix::Scalar>(seed >> 16U) / 65536;
  }
  return m;
}

template <class Scalar, int D>
void tessellations(const char* what) {
  using Matrix = Eigen::Matrix<Scalar, D, Eigen::Dynamic>;
  Bits bits;
  const auto points = made_up<Matrix>(D, 4000, 1);
  const auto [sites, owners, summary] = ccvt::tessellate(points, 50, {.threads = 2, .seed = 7});
  bits << sites << owners << summary.energy;

  ccvt::Problem<Scalar> problem(points, 50);
  problem.set_domain(ccvt::Domain::periodic(ccvt::Box::unit(D)));
  std::vector<ccvt::Index> capacities(50, 80);
  capacities[0] = 100;
  capacities[1] = 60;
  problem.set_capacities(capacities);
  problem.set_initial_sites(made_up<Matrix>(D, 50, 2));
  int iterations = 0;
  ccvt::Solver<Scalar> solver(problem, {.threads = 1, .on_iteration = [&](const auto& record) {
                                          iterations = record.iteration;
                                          return true;
                                        }});
  while (solver.step()) bits << solver.sites();
  ccvt::Solver<Scalar> moved = std::move(solver);
  bits << moved.owners() << double(iterations);
  bits << Eigen::Matrix<Scalar, D, Eigen::Dynamic>(ccvt::tessellate<D>(problem).sites);
  const ccvt::Tessellation cells(owners, 50);
  bits << double(cells.cell(3)[0]) << ccvt::capacity_error(owners, 50);
  bits << ccvt::lloyd(points, 50, {.threads = 2}).sites;
  bits << ccvt::energy(points, sites, owners);
  const std::vector<double> masses(owners.size(), 0.5);
  const auto weighed = ccvt::tessellate_masses(points, masses, 50);
  bits << weighed.sites << weighed.owners << weighed.largest_mass_error;
  bits.print(what);
}

void samplings() {
  Bits bits;
  const ccvt::Box box{{-1, -2, -3}, {1, 2, 3}};
  bits << ccvt::sample_uniform<float, 3>(box, 1000, 1) << ccvt::sample_uniform(box, 1000, 2);
  bits << ccvt::Box{Eigen::Vector2d(0, 1), Eigen::Vector2d(2, 4)}.extent();
  const auto values = made_up<Eigen::ArrayXf>(64, 1, 3);
  const std::vector<std::uint8_t> mask(64, 1);
  const ccvt::Grid grid = ccvt::Grid::spaced({4, 4, 4}, Eigen::Vector3d(1, 2, 3), {10, 20, 30});
  const std::vector<float> stored(values.data(), values.data() + values.size());
  ccvt::DensityGrid density = grid.density(std::span<const float>(stored));
  density.mask = mask;
  density.map = [](double value) { return value * 2; };
  bits << ccvt::sample_density<double, 3>(density, 500)
       << ccvt::sample_density<float>(density, 500);
  const auto half = [](std::span<const double> x) { return x[0] < 0 ? 1.0 : 0.5; };
  bits << ccvt::sample_function<float>(half, 1, box, 500, 4);
  const auto samples = ccvt::sample_volume(density, 20);
  bits << samples.sites << samples.weights << samples.radii << grid.cell_volume();
  bits.print("sampling");
}

void codebooks(const std::filesystem::path& directory) {
  Bits bits;
  const auto vectors = made_up<Eigen::MatrixXf>(6, 1000, 5);
  const auto [codebook, codes, summary] = ccvt::train_codebook(vectors, 16, {.seed = 7});
  bits << codes << Eigen::MatrixXd(codebook.codewords()) << Eigen::VectorXd(codebook.weights());
  bits << codebook.encode(vectors, ccvt::Coding::weighted, 2) << codebook.decode(codes);
  bits << codebook.distortion(vectors, codes) << summary.gap;
  bits << ccvt::train_codebook_from(vectors, codebook.codewords(), {.max_iterations = 2}).codes;
  codebook.save(directory / "c.npy", directory / "w.npy");
  const auto loaded = ccvt::Codebook::load(directory / "c.npy", directory / "w.npy");
  bits << loaded.encode(vectors);
  bits << ccvt::Codebook(Eigen::Matrix2d::Identity()).encode(Eigen::Matrix2d::Ones().eval());
  bits.print("codebook");
}

void thinnings(const std::filesystem::path& directory) {
  Bits bits;
  const auto points = made_up<Eigen::Matrix3Xd>(3, 300, 10);
  ccvt::ThinOptions options;
  options.tessellation.threads = 2;
  const ccvt::Thinning few = ccvt::thin(points, 60, options, points);
  bits << few.chosen << few.owners << few.counts << few.energy << few.spacing;
  ccvt::write_points(directory / "cloud.npy", points);
  const ccvt::PointCloud cloud = ccvt::read_point_cloud(directory / "cloud.npy");
  ccvt::write_point_cloud(directory / "cloud.ply", cloud, few.chosen, few.counts);
  bits << ccvt::read_points<double>(directory / "cloud.ply");
  bits.print("thinnings");
}

void figures() {
  Bits bits;
  const auto points = made_up<Eigen::Matrix2Xd>(2, 200, 6);
  const std::vector<ccvt::PointSet> sets(
      2, ccvt::PointSet(points, ccvt::Domain::periodic(ccvt::Box::unit(2))));
  const ccvt::Analysis all = ccvt::analyze(sets, {.threads = 2});
  bits << all.distances.mean << all.spectrum.power << all.pairs.value << all.order.psi6_local
       << all.star_discrepancy << all.integration.step << Eigen::MatrixXd(sets[0].points());
  bits.print("metrics");
}

void files(const std::filesystem::path& directory) {
  Bits bits;
  const auto points = made_up<Eigen::Matrix3Xf>(3, 100, 8);
  for (const char* name : {"p.npy", "p.csv", "p.txt"}) {
    ccvt::write_points(directory / name, points);
    bits << ccvt::read_points<double>(directory / name)
         << ccvt::read_points<float>(directory / name);
  }
  ccvt::Image image{32, 32, std::vector<float>(1024, 0.25F)};
  image.values[5] = 1;
  {
    ccvt::Publication together;
    ccvt::write_png(directory / "i.png", image);
    bits << together.unpublished(directory / "i.png").extension().string();
    together.publish();
  }
  bits << ccvt::read_image(directory / "i.png").values;
  const auto dots = ccvt::stipple(image, 30);
  ccvt::write_svg(directory / "i.svg", dots);
  bits << dots.dots << dots.dot_radius << ccvt::render(dots).values;
  const auto sites = made_up<Eigen::Matrix3Xf>(3, 20, 9);
  ccvt::write_particles(directory / "p.gadget", sites, {.box_size = 8, .repeat = 2});
  bits << ccvt::read_points<double>(directory / "p.gadget");
  bits.print("files");
}

/// Exceptions of the library are caught by their types here.
void refusals() {
  Bits bits;
  const auto expect_refusal = [&](const auto& call) {
    try {
      call();
      std::puts("not refused");
    } catch (const ccvt::InvalidInput& error) {
      bits << std::string(error.what());
    }
  };
  const auto points = made_up<Eigen::Matrix2Xd>(2, 10, 9);
  expect_refusal([&] { ccvt::tessellate(points, 0); });
  expect_refusal([&] { ccvt::Options{.max_iterations = -1}.validate(); });
  expect_refusal([&] { ccvt::Domain::periodic({{0, 0}, {1, 0}}); });
  expect_refusal([&] { static_cast<void>(ccvt::find_preset("none")); });
  expect_refusal([&] { ccvt::validate_capacities(std::vector<ccvt::Index>{1, 2}, 4); });
  try {
    ccvt::write_text("/nowhere/at/all.txt", "");
  } catch (const ccvt::IoError& error) {
    bits << std::string(error.what());
  }
  bits.print("refusals");
}

}  // namespace

int main() {
  std::string pattern = (std::filesystem::temp_directory_path() / "ccvt-flags-XXXXXX").string();
  const std::filesystem::path directory = ::mkdtemp(pattern.data());
  tessellations<float, 2>("float 2D");
  tessellations<double, 3>("double 3D");
  tessellations<double, 4>("double 4D");
  samplings();
  codebooks(directory);
  thinnings(directory);
  figures();
  files(directory);
  refusals();
  std::filesystem::remove_all(directory);
  return 0;
}
