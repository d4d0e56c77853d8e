// Messages that no other test provokes: each has an example, see errors/check.py.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/ccvt.h"
#include "ccvt/point_cloud.h"
#include "ccvt/volume.h"
#include "support/files.h"
#include "support/message.h"
#include "support/npy.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

struct Example {
  std::function<void()> call;
  std::string message;  ///< a part of it
};

void check_all(const std::vector<Example>& examples) {
  for (const Example& example : examples) {
    CAPTURE(example.message);
    const std::string message = message_of(example.call);
    CAPTURE(message);
    CHECK(message.find(example.message) != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
  }
}

PointsView<float> many_on_one_line(std::ptrdiff_t count) {
  static const float number = 0;
  return view_points(Eigen::Map<const Eigen::RowVectorXf>(&number, count));
}

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE("error examples: points and problems") {
  const Points<float> points = sample_uniform<float>(Box::unit(2), 8, 1);
  const std::vector<Index> owners(8, 0);
  const float number = 0;
  Points<float> flat = Points<float>::Zero(3, 2);
  check_all({
      {[] { many_on_one_line(std::ptrdiff_t{1} << 31); },
       "points: there are 2147483648 of them, but at most 2147483647 are supported"},
      {[&] { put_back(points, owners, flat, [](std::span<const double>) { return true; }); },
       "sites: have 3 dimensions, the points 2"},
      {[] {
         Problem<float>(PointsView<float>{nullptr, 2, 3, 2}, 1);
       },
       "points: the view has no data"},
      {[&] {
         Problem<float>(PointsView<float>{&number, 2, 3, 1}, 1);
       },
       "points: the stride is 1: it must be at least the dimension, 2"},
      {[&] {
         Problem<float>(points, 2).set_initial_owners({0, 0, 0, 0, 1, 1, 1, 2});
       },
       "initial_owners[7] is 2: it must be in 0..1"},
      {[&] {
         const Solver<float>* called = nullptr;
         Solver<float> solver(Problem<float>(points, 2), {.cancelled = [&] {
                                return called != nullptr && called->owners().empty();
                              }});
         called = &solver;
         solver.run();
       },
       "Solver::owners: is called by Options::cancelled, which is asked in the middle of an "
       "iteration; it may be called by on_iteration"},
      {[&] { energy(points, flat, owners); }, "sites: have 3 coordinates, points have 2"},
      {[&] {
         const Points<double> far = Points<double>::Constant(2, 8, 1e200);
         const Points<double> site = Points<double>::Zero(2, 1);
         energy(far, site, owners);
       },
       "the sum of their squared distances exceeds the range of double"},
      {[&] { energy(points, Points<float>(2, 0), owners); }, "sites: there are none"},
      {[] { normalized_energy(NAN, 4, 1, Box::unit(2)); }, "energy: is nan; must be at least 0"},
      {[] { normalized_energy(1, 0, 1, Box::unit(2)); }, "points: 0 is not positive"},
      {[] { normalized_energy(1, 4, 1, Box()); }, "box: has no dimension"},
      {[] {
         normalized_energy(1, 4, 1, Box{{0, 0}, {1, 0}});
       },
       "box: dimension 1 goes from 0 to 0; its extent must be positive"},
      {[] { LinearMap::units(Coordinates()); }, "units: there are none"},
      {[] {
         static_cast<void>(LinearMap::units({1, 2})(Domain::euclidean(Box::unit(3))));
       },
       "domain: its box has 3 dimensions, the map has 2"},
      {[] {
         sample_function<double>([](std::span<const double>) { return 1e308; }, 1e308, Box::unit(2),
                                 100);
       },
       "density: the sum over candidates overflows"},
      {[] {
         const PointSet set(sample_uniform<double>(Box::unit(40), 3, 1),
                            Domain::periodic(Box::unit(40)));
         power_spectrum({&set, 1}, {.ring_width = 2e-5});
       },
       "ring_width: makes "},
      {[] {
         const PointSet set(sample_uniform<double>(Box::unit(2), 500, 1),
                            Domain::periodic(Box::unit(2)));
         power_spectrum({&set, 1}, {.max_frequency = 1e8});
       },
       "max_frequency: 1e+08 makes more than a million rings of width 0.04"},
  });
}

TEST_CASE("error examples: codebooks") {
  const Points<double> vectors = sample_uniform<double>(Box::unit(2), 8, 1);
  const Codebook codebook(Points<double>(vectors.leftCols(2)));
  const std::vector<Index> codes(8, 0);
  check_all({
      {[&] { code_usage(codes, 0); }, "codewords is 0: it must be positive"},
      {[] { code_usage({}, 2); }, "codes: there are none"},
      {[] { Codebook(Points<double>(0, 0)); }, "codewords: there are 0 of 0 dimensions"},
      {[&] { static_cast<void>(codebook.encode(vectors, Coding::nearest, -1)); },
       "threads: is -1; must be from 0 (one per processor) to 4096"},
      {[&] { static_cast<void>(codebook.distortion(vectors, std::span(codes).first(3))); },
       "codes: there are 3 for 8 vectors"},
      {[&] { train_codebook_from(vectors, Columns<double>(3, 2)); },
       "codewords: have 3 dimensions, but the vectors have 2"},
  });
}

TEST_CASE("error examples: volumes and surfaces") {
  Volume volume;
  volume.grid = Grid::spaced({2, 2, 2}, {1, 1, 1}, {0, 0, 0});
  volume.data.resize(8);
  const std::vector<float> values(8, 1.0F);
  const DensityGrid grid = volume.grid.density(values);
  TriangleMesh mesh;
  mesh.vertices = Points<double>(Points<double>::Identity(3, 3));
  mesh.triangles = Columns<Index>(2, 1);
  TriangleMesh whole = mesh;
  whole.triangles = Columns<Index>(3, 1);
  whole.triangles.eigen().col(0) << 0, 1, 2;
  const double most = std::numeric_limits<double>::max();
  check_all({
      {[] {
         Grid::spaced({2, 2, 2}, {1, 1}, {0, 0, 0});
       },
       "grid: the shape has 3 dimensions, the spacing 2 and the origin 3"},
      {[] {
         Grid::spaced({2, 2, 2}, {1, 0, 1}, {0, 0, 0});
       },
       "grid: spacing[1] is 0; must be positive and finite"},
      {[&] {
         const ValueMap map{.kind = ValueMap::Kind::window, .low = -most, .high = most};
         map.validate();
       },
       "high: is too far from low, -1.79769"},
      {[&] { static_cast<void>(volume.density({.kind = ValueMap::Kind::gamma, .gamma = 2})); },
       "volume: its greatest value is 0; must be positive for a gamma"},
      {[&] { preview(grid, Points<double>(Points<double>::Zero(2, 1))); },
       "preview: the grid has 3 dimensions and the sites have 2; both need 3"},
      {[&] { mesh.validate(); }, "mesh: triangles are 2 x 1; needs 3 rows"},
      {[&] { preview(whole, SurfaceSamples()); },
       "samples: there are 0 sites, 0 normals and 0 radii"},
  });
}

TEST_CASE("error examples: writing") {
  const TemporaryDirectory directory;
  PointCloud cloud;
  cloud.points = Points<double>(Points<double>::Zero(4, 1));
  VolumeSamples samples;
  samples.sites = Points<double>(Points<double>::Zero(4, 1));
  samples.capacities = {1};
  samples.weights = {1};
  samples.radii = {1};
  const std::vector<Index> one = {0};
  const ColourImage image{2, 2, {1, 2, 3}};
  check_all({
      {[&] { write_point_cloud(directory / "c.ply", cloud, one, one); },
       "c.ply: points of 4 dimensions go into .csv, .txt or .npy"},
      {[&] { write_samples(directory / "s.vtk", samples); },
       "s.vtk: samples of 4 dimensions go into .csv, .txt or .npy"},
      {[&] { write_png(directory / "i.png", image); },
       "image: has 3 values for 2 x 2 pixels; from 1 to 268435456 pixels with 3 values each"},
      {[&] {
         const auto path = put(directory / "gone", "");
         const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
         ::unlink(path.c_str());
         const std::string name = "/proc/self/fd/" + std::to_string(file);
         const std::string message = message_of([&] { write_text(name, ""); });
         ::close(file);
         throw IoError(message);
       },
       "cannot be written: is a link to a file that has no name"},
  });
  CHECK(directory.entries() == 0);
}

TEST_CASE("error examples: reading") {
  const TemporaryDirectory directory;
  const auto file = [&](const std::string& name, const std::string& bytes) {
    return put(directory / name, bytes);
  };
  const auto points_of = [&](const std::string& name, const std::string& bytes) {
    return [path = file(name, bytes)] { read_points<float>(path); };
  };
  const auto volume_of = [&](const std::string& name, const std::string& bytes,
                             VolumeLayout layout = {}) {
    return [path = file(name, bytes), layout] { read_volume(path, layout); };
  };
  const auto longer = [](const std::filesystem::path& path, std::uint64_t size) {
    std::filesystem::resize_file(path, size);  // with holes: it takes no space
    return path;
  };
  std::filesystem::create_symlink("circle.npy", directory / "circle.npy");
  const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
  const std::string cube = npy_file("|u1", "(2, 2, 2)", std::string(8, '\1'));
  const std::string kilobytes(std::size_t{1} << 17, 'c');
  const std::string megabytes(std::size_t{40} << 20, '1');
  check_all({
      {[&] { read_points<float>(directory / "circle.npy"); },
       "circle.npy: cannot be opened: Too many levels of symbolic links"},
      {points_of("dim.fvecs", number_bytes<std::int32_t>({0, 1})),
       "vector 0 has 0 dimensions; from 1 to 16777216 are supported"},
      {points_of("odd.fvecs", number_bytes<std::int32_t>({2, 1, 1, 1})),
       "has 16 bytes, not a multiple of the 12 that a vector of 2 dimensions takes"},
      {points_of("two.fvecs", number_bytes<std::int32_t>({1, 1, 2, 1})),
       "vector 1 has 2 dimensions, but vector 0 has 1; all need the same number"},
      {[path = longer(file("many.bvecs", number_bytes<std::int32_t>({1})),
                      5 * (std::uint64_t{1} << 31))] { read_points<float>(path); },
       "has 2147483648 points to be read; at most 2147483647 are supported at once"},
      {[path = longer(file("wide.npy", npy_file("|u1", "(1, 16777217)", "")),
                      npy_file("|u1", "(1, 16777217)", "").size() + 16777217)] {
         read_points<float>(path);
       },
       "has the shape (1, 16777217); at most 16777216 dimensions are supported"},
      {[path = file("n.npy", npy_file("<f4", "(2,)", number_bytes<float>({1, NAN})))] {
         read_numbers(path);
       },
       "row 1: nan is not finite; numbers must be finite"},
      {[path = file("long.csv", megabytes + megabytes)] { read_points<float>(path); },
       "is longer than 64 MiB; this is not"},
      {[path = file("long.obj", "v " + megabytes + "\\\n" + megabytes + "\\\n1\n")] {
         read_mesh(path);
       },
       "continues lines of more than 64 MiB"},
      {[path = file("long.ply", "ply\nformat ascii 1.0\ncomment " + kilobytes + "\n")] {
         read_mesh(path);
       },
       "has a line of more than 65536 bytes"},
      {[path = longer(file("large.png", "\x89PNG\r\n\x1a\n"), (std::uint64_t{1} << 31) + 1)] {
         read_image(path);
       },
       "large.png: is larger than 2 GiB"},
      {points_of("l.gadget", number_bytes<std::int32_t>({8}) + "HEAD" +
                                 number_bytes<std::int32_t>({264, 8, 256}) +
                                 number_bytes<std::int32_t>({0, 1, 0, 0, 0, 0}) +
                                 std::string(232, '\0') +
                                 number_bytes<std::int32_t>({256, 12, 0, 0, 0, 0, 12})),
       "has a block without a label of 8 bytes"},
      {volume_of("v.nrrd", nrrd + "spacings: 1 0 1\n\n" + std::string(8, '\1')),
       "field 'spacings': is 0; spacings must not be"},
      {volume_of("m.nrrd", nrrd + "axis mins: 0 0 0\n\n" + std::string(8, '\1')),
       "places its axes by 'axis mins' and 'axis maxs'"},
      {volume_of("n.nrrd",
                 nrrd + "spacings: 1 2 1\naxis mins: 0 -9 NaN\n\n" + std::string(8, '\1')),
       "field 'axis mins': '-9' may be a border of cells or the middle of one"},
      {volume_of("a.npy", cube, {.spacing = {1, 1}}), "spacing: has 2 numbers for"},
      {volume_of("b.npy", cube, {.spacing = {1, -1, 1}}),
       "spacing: entry 1 is -1; must be positive"},
      {volume_of("c.npy", npy_file("|u1", "(2, 4)", std::string(8, '\1'))),
       "has the shape (2, 4); a volume needs 3 extents"},
  });
}

TEST_SUITE_END();

#ifdef CCVT_PROGRAM
TEST_SUITE_BEGIN("cli");

TEST_CASE("error examples: the program") {
  const TemporaryDirectory directory;
  write_points(directory / "p.csv", sample_uniform<double>(Box::unit(2), 8, 1));
  put(directory / "out.csv", "0.5 0.5\n2 0.5\n");
  write_png(directory / "i.png", Image{8, 8, std::vector<float>(64, 0.5F)});
  const std::string quantize = "quantize p.csv --codewords 3 -o o.csv ";
  const std::vector<std::pair<std::string, std::string>> examples = {
      {"analyze p.csv --compare " + std::string(41, 'n') + "=p.csv -o out",
       "--compare: the name '" + std::string(41, 'n') +
           "' is longer than 40 letters; see ccvt analyze --help"},
      {"quantize i.png --image-blocks 16 --codewords 2 -o o.csv",
       "i.png: blocks of 16 x 16 pixels do not fit into 8 x 8"},
      {quantize + "--seeding kmeans",
       "--seeding: 'kmeans' is neither kmeans++ nor random nor a file of codewords, .npy, .csv, "
       ".txt, .ply, .fvecs, .bvecs, .gadget or .hdf5"},
      {"quantize p.csv --codewords 9 -o o.csv",
       "p.csv: has 8 vectors, but --codewords is 9: each needs one at least"},
      {quantize + "--seeding out.csv", "out.csv: has 2 codewords, but --codewords is 3"},
      {quantize + "--image-out o.png",
       "--image-out: needs --image-blocks; see ccvt quantize --help"},
      {quantize + "--method lloyd --weights-out w.csv",
       "--weights-out: only --method exact finds weights"},
      {quantize + "--method lloyd --capacities p.csv",
       "--capacities: --method lloyd does not keep any"},
      {"sample --dim 2 --sites 4 --fixed-sites out.csv -o o.csv",
       "out.csv: coordinate 0 of sites[1] is 2; it must be in the unit box"},
      {"tessellate p.csv --sites 2 --shares-out s.csv -o o.csv",
       "--shares-out: needs --masses or --mass-column"},
      {"tessellate p.csv --sites 2 --masses p.csv --whiten -o o.csv",
       "--whiten: cannot be combined with masses"},
  };
  for (const auto& example : examples) {
    CAPTURE(example.first);
    const Ran ran = run(directory, example.first);
    CHECK(ran.status == 2);
    CHECK(ran.errors == "ccvt: error: " + example.second + "\n");
  }
  CHECK(directory.entries() == 3);
}

TEST_SUITE_END();
#endif

}  // namespace ccvt::test
