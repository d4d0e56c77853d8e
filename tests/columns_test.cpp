// Which columns of a file are coordinates: in the library and in the program.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/point_cloud.h"
#include "support/files.h"
#include "support/message.h"
#include "support/npy.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

using Names = std::vector<std::string>;

/// What `ccvt volume` writes.
const std::string kSamples =
    "x,y,z,radius,capacity,weight\n"
    "1,2,3,.5,16,7\n"
    "4,5,6,.5,16,7\n"
    "7,8,9,.5,16,7\n";

Points<double> matrix(Eigen::Index rows, const std::vector<double>& values) {
  return Eigen::Map<const Points<double>>(values.data(), rows,
                                          static_cast<Eigen::Index>(values.size()) / rows);
}

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE("columns: those that a header calls x, y, z or x0, x1 are the coordinates") {
  const TemporaryDirectory directory;
  struct Case {
    std::string text;
    Points<double> points;
    Names columns;
    Names left_out;
  };
  const Case cases[] = {
      {kSamples,
       matrix(3, {1, 2, 3, 4, 5, 6, 7, 8, 9}),
       {"x", "y", "z"},
       {"radius", "capacity", "weight"}},
      {"# by hand\nname;Y;X\nfirst;1;2\nsecond;3;4\n",
       matrix(2, {2, 1, 4, 3}),
       {"X", "Y"},
       {"name"}},
      {"\"x\" \"z\" \"id\"\n1 2 3\n", matrix(2, {1, 2}), {"x", "z"}, {"id"}},
      {"x1,w,x0,x3\n1,2,3,4\n", matrix(2, {3, 1}), {"x0", "x1"}, {"w", "x3"}},
      // What is left out may be any text, or none; quotes keep together what is between them.
      {"city,x,\"heat, in K\",y\n\"Paris, #1\",\"1\",,2\nNew York; \"NY\",3,n/a,4\n,5, ,6 # last\n",
       matrix(2, {1, 2, 3, 4, 5, 6}),
       {"x", "y"},
       {"city", "heat, in K"}},
      // What parted fields before parts them after a blank line, too.
      {"x;y;town\n1;2;Rome, GA\n\n# those that are far\n3;4;Paris, TX\n",
       matrix(2, {1, 2, 3, 4}),
       {"x", "y"},
       {"town"}},
      {"name x y\n'a 1 2\n\"b c\" 3 4\n", matrix(2, {1, 2, 3, 4}), {"x", "y"}, {"name"}},
      // Tabs of a header keep blanks together, in rows that have as many.
      {"home town\tx\ty\nNew York\t1\t2\n\t 3\t4 \nRome 5   6\n",
       matrix(2, {1, 2, 3, 4, 5, 6}),
       {"x", "y"},
       {"home town"}},
      {"\t1\t2\n 3\t 4\n", matrix(2, {1, 2, 3, 4}), {}, {}},
      // Without x or x0 all are, as in a file without a header.
      {"longitude in degrees, latitude\n1,2\n",
       matrix(2, {1, 2}),
       {"longitude in degrees", "latitude"},
       {}},
      {"y,z\n1,2\n", matrix(2, {1, 2}), {"y", "z"}, {}},
      {"1,2\n", matrix(2, {1, 2}), {}, {}},
      // A title, not a list of names.
      {"points of x\n1 2\n", matrix(2, {1, 2}), {}, {}},
      {"points, of x\n1 2 3\n", matrix(3, {1, 2, 3}), {}, {}},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const auto path = put(directory / "p.csv", c.text);
    CHECK(read_points<double>(path) == c.points);
    const PointsHeader header = inspect_points(path);
    CHECK(header.dimension == c.points.rows());
    CHECK(header.columns == c.columns);
    CHECK(header.left_out == c.left_out);
  }
}

TEST_CASE("columns: a header names all or none") {
  const TemporaryDirectory directory;
  const auto refusal = [&](const std::string& text) {
    const auto path = put(directory / "p.csv", text);
    const std::string message = message_of([&] { read_points<double>(path); });
    CHECK(message_of([&] { inspect_points(path); }) == message);
    CHECK(message_of([&] { ccvt::read_point_cloud(path); }) == message);
    return message.substr(message.find("p.csv"));
  };
  const std::string rule = "; all columns need a name, or none";
  CHECK(refusal("# cities\nx,y\n1,2,3\n") ==
        "p.csv: line 3: has 3 fields, but line 2 names 2 columns" + rule);
  CHECK(refusal("x;y;m\n1;2\n") ==
        "p.csv: line 2: has 2 fields, but line 1 names 3 columns" + rule);
  CHECK(refusal("x\ty\n\n1\t2\t3\n") ==
        "p.csv: line 3: has 3 fields, but line 1 names 2 columns" + rule);
}

TEST_CASE("columns: by name or number, in any order, from every format") {
  const TemporaryDirectory directory;
  const auto csv = put(directory / "p.csv", kSamples);
  const std::vector<float> rows = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::vector<float> columns = {1, 4, 7, 2, 5, 8, 3, 6, 9};
  const auto c_order = put(directory / "c.npy", npy_file("<f4", "(3, 3)", number_bytes(rows)));
  const auto fortran =
      put(directory / "f.npy", npy_file("<f4", "(3, 3)", number_bytes(columns), true));
  std::string vecs;
  for (std::size_t p = 0; p < 3; ++p) {
    vecs += number_bytes(std::vector<std::int32_t>{3}) +
            number_bytes(std::vector<float>(rows.begin() + 3 * static_cast<std::ptrdiff_t>(p),
                                            rows.begin() + 3 * static_cast<std::ptrdiff_t>(p + 1)));
  }
  const auto fvecs = put(directory / "p.fvecs", vecs);
  const auto ply = put(directory / "p.ply",
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                       "property list uchar int tags\nproperty float y\nproperty double weight\n"
                       "end_header\n1 0 2 3\n4 1 9 5 6\n7 0 8 9\n");
  const Points<double> expected = matrix(2, {3, 1, 6, 4, 9, 7});
  for (const auto& path : {csv, c_order, fortran, fvecs, ply}) {
    CAPTURE(path.string());
    const ReadOptions third_and_first{.columns = {"3", "1"}};
    CHECK(read_points<double>(path, third_and_first) == expected);
    CHECK(read_points<float>(path, third_and_first) == expected.cast<float>());
    CHECK(inspect_points(path, third_and_first).dimension == 2);
    CHECK(inspect_points(path, third_and_first).left_out.empty());
  }
  CHECK(read_points<double>(csv, {.columns = {"z", "x"}}) == expected);
  CHECK(read_points<double>(csv, {.columns = {"radius"}}) == matrix(1, {.5, .5, .5}));
  CHECK(read_points<double>(ply, {.columns = {"weight", "x"}}) == expected);
  CHECK(inspect_points(ply, {.columns = {"x"}}).scalar == ScalarType::float32);
  // Fields that are no coordinates may hold anything.
  put(directory / "n.csv", "name,a,b\nfirst,1,nan\nsecond,2,\"\"\n");
  CHECK(read_points<double>(directory / "n.csv", {.columns = {"a"}}) == matrix(1, {1, 2}));
}

TEST_CASE("columns: what is not there is refused with a list of what is") {
  const TemporaryDirectory directory;
  put(directory / "p.csv", kSamples);
  put(directory / "twice.csv", "x,y,x\n1,2,3\n");
  put(directory / "plain.txt", "1 2\n");
  put(directory / "p.npy", npy_file("<f4", "(1, 2)", number_bytes(std::vector<float>{1, 2})));
  put(directory / "p.ply",
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n"
      "1 2\n");
  struct Case {
    std::string file;
    Names columns;
    std::string expected;
  };
  const Case cases[] = {
      {"p.csv",
       {"x", "mass"},
       "p.csv: has no column 'mass': its columns are 'x', 'y', 'z', 'radius', 'capacity', "
       "'weight'"},
      {"p.csv", {"7"}, "has no column '7': its columns are 'x'"},
      {"p.csv", {"0"}, "has no column '0'"},
      {"p.csv", {"x", "1"}, "column '1' is asked for twice"},
      {"twice.csv", {}, "has two columns 'x'"},
      {"twice.csv", {"y", "x"}, "has two columns 'x'; say which are coordinates by their numbers"},
      {"plain.txt",
       {"x"},
       "has no column 'x': its columns have no names, only numbers, from 1 to 2"},
      {"p.npy", {"3"}, "has no column '3': its columns have no names, only numbers, from 1 to 2"},
      {"p.ply", {"z"}, "has no column 'z': its columns are 'x', 'y'"},
  };
  for (const Case& c : cases) {
    const auto path = directory / c.file;
    const std::string message =
        message_of([&] { read_points<double>(path, {.columns = c.columns}); });
    CAPTURE(message);
    CHECK(message.find(c.expected) != std::string::npos);
    CHECK(message_of([&] { inspect_points(path, {.columns = c.columns}); }) == message);
  }
  CHECK(read_points<double>(directory / "twice.csv", {.columns = {"1", "3"}}) == matrix(2, {1, 3}));
}

TEST_SUITE_END();

#ifdef CCVT_PROGRAM
TEST_SUITE_BEGIN("cli");

TEST_CASE("columns: the program takes the coordinates of a table, and says what it leaves out") {
  const TemporaryDirectory directory;
  put(directory / "s.csv", kSamples);
  put(directory / "p.csv", "1,2,3\n4,5,6\n7,8,9\n");
  const Ran plain = run(directory, "tessellate p.csv --sites 2 -q -o plain.csv");
  CHECK(plain.errors == "");
  const Ran ran = run(directory, "tessellate s.csv --sites 2 -o named.csv");
  CHECK(ran.status == 0);
  CHECK(ran.errors ==
        "ccvt: s.csv: coordinates are x, y, z; left out: radius, capacity, weight; --columns says "
        "otherwise\n");
  CHECK(get(directory / "named.csv") == get(directory / "plain.csv"));
  put(directory / "yx.csv", "Y,x\n2,1\n5,4\n8,7\n");
  CHECK(run(directory, "tessellate yx.csv --sites 2 -o yx_out.csv").errors ==
        "ccvt: yx.csv: coordinates are x, Y, in this order; --columns says otherwise\n");
  CHECK(run(directory, "tessellate yx.csv --columns Y,x --sites 2 -o yx_out.csv").errors == "");
  put(directory / "xy.csv", "x,Y\n2,1\n5,4\n8,7\n");
  CHECK(run(directory, "tessellate xy.csv --initial-sites xy.csv -o xy_out.csv").errors == "");
  CHECK(run(directory, "tessellate xy.csv --initial-sites yx.csv -o xy_out.csv").errors ==
        "ccvt: yx.csv: coordinates are x, Y, in this order\n");
  put(directory / "names.csv", "id,lon,lat\n1,2,1\n2,5,4\n3,8,7\n");
  CHECK(run(directory, "tessellate names.csv --sites 2 -o names_out.csv").errors ==
        "ccvt: names.csv: coordinates are id, lon, lat; --columns says otherwise\n");
  CHECK(run(directory, "tessellate s.csv --sites 2 -q -o quiet.csv").errors == "");
  const Ran chosen = run(directory, "tessellate s.csv --columns x,y,z --sites 2 -o chosen.csv");
  CHECK(chosen.errors == "");
  CHECK(get(directory / "chosen.csv") == get(directory / "plain.csv"));
  CHECK(run(directory, "tessellate s.csv --columns 1,2 --sites 2 -q -o two.csv").status == 0);
  CHECK(inspect_points(directory / "two.csv").dimension == 2);

  const Ran quantized = run(directory, "quantize s.csv --columns x,y --codewords 2 -q -o book.csv");
  CHECK(quantized.status == 0);
  CHECK(run(directory, "encode s.csv --columns x,y --codebook book.csv -q -o codes.csv").status ==
        0);
  CHECK(run(directory, "analyze s.csv --columns x,y --box 0 0 10 10 -q -o report").status == 0);

  struct Case {
    std::string line;
    std::string expected;
  };
  const Case cases[] = {
      {"tessellate s.csv --columns x,mass --sites 2 -o o.csv", "s.csv: has no column 'mass'"},
      {"tessellate s.csv --columns x,,y --sites 2 -o o.csv", "--columns: 'x,,y' has an empty name"},
      {"quantize s.csv --columns x --image-blocks 4 --codewords 2 -o o.csv",
       "--columns: a picture"},
  };
  for (const Case& c : cases) {
    const Ran refused = run(directory, c.line);
    CAPTURE(refused.errors);
    CHECK(refused.status == 2);
    CHECK(refused.errors.rfind("ccvt: error: " + c.expected, 0) == 0);
  }
}

TEST_SUITE_END();
#endif

}  // namespace ccvt::test
