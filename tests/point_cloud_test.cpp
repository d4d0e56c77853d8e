#include "ccvt/point_cloud.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "random.h"
#include "support/files.h"
#include "support/message.h"
#ifdef CCVT_PROGRAM
#include "support/process.h"
#endif

namespace ccvt::test {
namespace {

template <class Number>
std::string bytes_of(Number number, bool big) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// What stands between the file's comments and the end of its header, of `vertices`.
std::string properties_of(int vertices) {
  return "element vertex " + std::to_string(vertices) +
         "\nproperty double x\nproperty char a\nproperty uchar b\nproperty short c\n"
         "property ushort d\nproperty int e\nproperty uint f\nproperty float y\n"
         "property float nx\nproperty float ny\nproperty float nz\n"
         "property list uchar short tags\nproperty float z\n";
}

/// A vertex with a property of each type; `tags` of them in its list.
std::string vertex_bytes(int p, int tags, bool big) {
  std::string bytes = bytes_of(0.1 * p, big) + bytes_of(static_cast<std::int8_t>(-p), big) +
                      bytes_of(static_cast<std::uint8_t>(250 - p), big) +
                      bytes_of(static_cast<std::int16_t>(-300 - p), big) +
                      bytes_of(static_cast<std::uint16_t>(65000 + p), big) +
                      bytes_of(-2000000000 - p, big) + bytes_of(4000000000U, big) +
                      bytes_of(0.5F * static_cast<float>(p), big) + bytes_of(0.0F, big) +
                      bytes_of(0.0F, big) + bytes_of(1.0F, big) +
                      bytes_of(static_cast<std::uint8_t>(tags), big);
  for (int t = 0; t < tags; ++t) bytes += bytes_of(static_cast<std::int16_t>(-t), big);
  return bytes + bytes_of(1.5F, big);
}

const std::string kFaces = "element face 1\nproperty list uchar int vertex_indices\n";

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE("PLY: what is chosen is written bit by bit, in either byte order") {
  const TemporaryDirectory directory;
  for (const std::string encoding : {"binary_little_endian", "binary_big_endian"}) {
    CAPTURE(encoding);
    const bool big = encoding == "binary_big_endian";
    const std::string head = "ply\nformat " + encoding + " 1.0\ncomment made by hand\nobj_info x\n";
    std::string data = head + properties_of(5) + kFaces + "end_header\n";
    std::vector<std::string> vertices;
    for (int p = 0; p < 5; ++p) vertices.push_back(vertex_bytes(p, p % 3, big));
    for (const std::string& vertex : vertices) data += vertex;
    data += bytes_of<std::uint8_t>(1, big) + bytes_of(0, big);
    const auto path = put(directory / "p.ply", data);
    const PointCloud cloud = read_point_cloud(path);
    CHECK(cloud.scalar == ScalarType::float64);
    REQUIRE(cloud.points.cols() == 5);
    CHECK(cloud.points.col(3) == Eigen::Vector3d(0.1 * 3, 1.5, 1.5));
    REQUIRE(cloud.normals.cols() == 5);
    CHECK(cloud.normals.col(4) == Eigen::Vector3d(0, 0, 1));
    CHECK(cloud.kept == std::vector<std::string>{"a", "b", "c", "d", "e", "f", "tags"});
    CHECK(cloud.dropped == std::vector<std::string>{"face"});
    const std::vector<Index> chosen = {1, 2, 4};
    const std::vector<Index> counts = {1, 258, 3};
    write_point_cloud(directory / "q.ply", cloud, chosen, counts);
    std::string expected = head + properties_of(3) + "property int count\nend_header\n";
    for (std::size_t k = 0; k < 3; ++k) {
      expected += vertices[static_cast<std::size_t>(chosen[k])] + bytes_of(counts[k], big);
    }
    CHECK(get(directory / "q.ply") == expected);
    // Again: the count that is there stays.
    const PointCloud again = read_point_cloud(directory / "q.ply");
    write_point_cloud(directory / "r.ply", again, std::vector<Index>{1}, std::vector<Index>{7});
    CHECK(get(directory / "r.ply") == head + properties_of(1) +
                                          "property int count\nproperty int count_2\nend_header\n" +
                                          vertices[2] + bytes_of(258, big) + bytes_of(7, big));
  }
}

TEST_CASE("PLY: of ascii the words are written, whatever they look like") {
  const TemporaryDirectory directory;
  const std::string head = "ply\nformat ascii 1.0\ncomment c\n";
  const auto properties = [](int vertices) {
    return "element vertex " + std::to_string(vertices) +
           "\nproperty float x\nproperty float y\nproperty list int float w\nproperty uchar red\n"
           "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n";
  };
  const auto path = put(directory / "p.ply", head + "element face 1\nproperty list uchar int i\n" +
                                                 properties(3) +
                                                 "end_header\n3 0 1 2\r\n"
                                                 "0.10000 1e0 0 007 3 0 0 1\n\n"
                                                 "-0 +2 2 nan 1 255 4.0 nan 0 1 surplus\r\n"
                                                 "1.25 2 1 .5 0 5 0 0 -1");
  const PointCloud cloud = read_point_cloud(path);
  CHECK(cloud.scalar == ScalarType::float32);
  CHECK(cloud.unknown_normals == 1);
  CHECK(cloud.normals.col(1) == Eigen::Vector3d(0, 0, 0));
  CHECK(cloud.normals.col(2) == Eigen::Vector3d(0, 0, -1));
  write_point_cloud(directory / "q.ply", cloud, std::vector<Index>{0, 1, 2},
                    std::vector<Index>{1, 2, 3});
  CHECK(get(directory / "q.ply") == head + properties(3) +
                                        "property int count\nend_header\n"
                                        "0.10000 1e0 0 007 3 0 0 1 1\n"
                                        "-0 +2 2 nan 1 255 4.0 nan 0 1 2\n"
                                        "1.25 2 1 .5 0 5 0 0 -1 3\n");
  // Normals belong to points in space.
  const ReadOptions flat{.columns = {"x", "y"}};
  CHECK(read_point_cloud(path, flat).normals.cols() == 0);
}

TEST_CASE("text: fields are written word by word, with a header where there was one") {
  const TemporaryDirectory directory;
  const auto path = put(directory / "p.csv",
                        "x,y,z,nx,ny,nz,label\n1,2,3.50,0,0,1,7 # first\n\n4,5,6e0,0,0,nan,-1\n");
  const PointCloud cloud = read_point_cloud(path);
  CHECK(cloud.points.col(1) == Eigen::Vector3d(4, 5, 6));
  CHECK(cloud.unknown_normals == 1);
  CHECK(cloud.kept == std::vector<std::string>{"label"});
  const std::vector<Index> both = {0, 1};
  const std::vector<Index> counts = {3, 4};
  write_point_cloud(directory / "q.csv", cloud, both, counts);
  CHECK(get(directory / "q.csv") ==
        "x,y,z,nx,ny,nz,label,count\n1,2,3.50,0,0,1,7,3\n4,5,6e0,0,0,nan,-1,4\n");
  write_point_cloud(directory / "q.txt", cloud, both, counts);
  CHECK(get(directory / "q.txt").find("x y z nx ny nz label count\n1 2 3.50") == 0);
  put(directory / "bare.txt", "1 2\n3 4\n");
  write_point_cloud(directory / "q.txt", read_point_cloud(directory / "bare.txt"),
                    std::vector<Index>{1}, std::vector<Index>{2});
  CHECK(get(directory / "q.txt") == "3 4 2\n");
}

TEST_CASE("text: what a field holds stays one field, whatever parts fields") {
  const TemporaryDirectory directory;
  const std::vector<Index> all = {0, 1, 2, 3};
  const std::string rows =
      "1,2,New York,\"a, b\",\n3,4,Rome,\"say \"\"hi\"\"\",7\n5,6,\"#1\",;,x\n7,8,1;5,,\" \"\n";
  const auto path = put(directory / "p.csv", "x,y,\"the, town\",b,c\n" + rows);
  const PointCloud cloud = read_point_cloud(path);
  REQUIRE(cloud.points.cols() == 4);
  write_point_cloud(directory / "q.csv", cloud, all, all);
  CHECK(get(directory / "q.csv") ==
        "x,y,\"the, town\",b,c,count\n1,2,New York,\"a, b\",,0\n3,4,Rome,\"say \"\"hi\"\"\",7,1\n"
        "5,6,\"#1\",\";\",x,2\n7,8,\"1;5\",,\" \",3\n");
  write_point_cloud(directory / "q.txt", cloud, all, all);
  CHECK(get(directory / "q.txt") ==
        "x y \"the, town\" b c count\n1 2 \"New York\" \"a, b\" \"\" 0\n"
        "3 4 Rome \"say \"\"hi\"\"\" 7 1\n5 6 \"#1\" \";\" x 2\n7 8 \"1;5\" \"\" \" \" 3\n");
  for (const char* const again : {"q.csv", "q.txt"}) {
    const PointCloud back = read_point_cloud(directory / again);
    CHECK(back.points == cloud.points);
    CHECK(back.kept == std::vector<std::string>{"the, town", "b", "c", "count"});
  }
}

TEST_CASE("points of other files are written with their counts") {
  const TemporaryDirectory directory;
  Points<float> points(3, 2);
  points << 1, 2, 3, 4, 0.1F, 6;
  write_points(directory / "p.npy", points);
  const PointCloud cloud = read_point_cloud(directory / "p.npy");
  const std::vector<Index> one = {0};
  write_point_cloud(directory / "q.csv", cloud, one, one);
  CHECK(get(directory / "q.csv") == "x,y,z,count\n1,3,0.1,0\n");
  write_point_cloud(directory / "q.npy", cloud, one, one);
  CHECK(read_points<float>(directory / "q.npy") == points.leftCols(1));
  write_point_cloud(directory / "q.ply", cloud, one, one);
  CHECK(get(directory / "q.ply").find("property float z\nproperty int count\nend_header\n") !=
        std::string::npos);
  CHECK(read_points<float>(directory / "q.ply") == points.leftCols(1));
}

TEST_CASE("bad clouds and choices are refused") {
  const TemporaryDirectory directory;
  const auto refusal = [&](const std::string& text) {
    put(directory / "p.ply", text);
    const std::string message = message_of([&] { read_point_cloud(directory / "p.ply"); });
    const std::string name = (directory / "p.ply").string() + ": ";
    return message.find(name) == 0 ? message.substr(name.size()) : message;
  };
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n";
  CHECK(refusal(head + "1 2 nan 0 0 1\n") ==
        "vertex 0: 'nan' is not finite; coordinates must be finite");
  CHECK(refusal(head + "1 2 3 0 up 1\n") == "vertex 0: 'up' is not a number");
  CHECK(refusal(head + "1 2 3 0 1\n") == "vertex 0: has too few numbers");
  CHECK(refusal(head) == "is truncated: it ends before vertex 0");
  put(directory / "p.csv", "1,2\n3\n");
  CHECK(message_of([&] {
          read_point_cloud(directory / "p.csv");
        }).find("line 2: has 1 fields, but line 1 has 2; all points need the same number") !=
        std::string::npos);
  put(directory / "p.csv", "1,2\n3,4\n");
  const PointCloud cloud = read_point_cloud(directory / "p.csv");
  const auto write = [&](const char* name, const std::vector<Index>& chosen,
                         const std::vector<Index>& counts) {
    return message_of([&] { write_point_cloud(directory / name, cloud, chosen, counts); });
  };
  CHECK(write("q.csv", {0, 2}, {1, 1}) == "chosen[1] is 2: it must be in 0..1");
  CHECK(write("q.csv", {-1}, {1}) == "chosen[0] is -1: it must be in 0..1");
  CHECK(write("q.csv", {0}, {}) == "counts: there are 0 for 1 points; needs one for each");
  CHECK(write("q.las", {0}, {1}).find("unknown extension '.las'") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(directory / "q.csv"));
}

TEST_CASE("clouds that are cut or altered anywhere are read or refused, and nothing else") {
  const TemporaryDirectory directory;
  std::vector<std::string> seeds;
  for (const bool big : {false, true}) {
    std::string data = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                       "_endian 1.0\n" + properties_of(3) + "end_header\n";
    for (int p = 0; p < 3; ++p) data += vertex_bytes(p, p, big);
    seeds.push_back(std::move(data));
  }
  seeds.emplace_back(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty list uchar int l\n"
      "property float y\nend_header\n1 2 0 0 2\n3 1 9 4\n");
  Random random(12);
  int read = 0;
  int refused = 0;
  for (const std::string& seed : seeds) {
    for (int k = 0; k < 400; ++k) {
      std::string text = seed;
      if (k % 2 == 0) text.resize(random.below(text.size() + 1));
      for (std::uint64_t n = random.below(4); n > 0 && !text.empty(); --n) {
        text[random.below(text.size())] = static_cast<char>(random.below(256));
      }
      put(directory / "p.ply", text);
      try {
        const PointCloud cloud = read_point_cloud(directory / "p.ply");
        std::vector<Index> all;
        for (Index p = 0; p < cloud.points.cols(); ++p) all.push_back(p);
        write_point_cloud(directory / "q.ply", cloud, all, all);
        CHECK(read_point_cloud(directory / "q.ply").points == cloud.points);
        ++read;
      } catch (const InvalidInput&) {
        ++refused;
      }
    }
  }
  CHECK(read > 50);
  CHECK(refused > 50);
}

#ifdef CCVT_PROGRAM

TEST_SUITE_END();
TEST_SUITE_BEGIN("cli");

namespace {

/// A PLY file of `count` points with a number each, and faces.
std::string numbered_ply(int count) {
  Random random(2);
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) +
                     "\nproperty float x\nproperty float y\nproperty float z\nproperty int id\n" +
                     kFaces + "end_header\n";
  for (int p = 0; p < count; ++p) {
    for (int d = 0; d < 3; ++d) text += std::to_string(random.uniform()) + ' ';
    text += std::to_string(p) + '\n';
  }
  return text + "3 0 1 2\n";
}

}  // namespace

TEST_CASE("thin writes chosen points, their numbers and owners") {
  const TemporaryDirectory directory;
  put(directory / "p.ply", numbered_ply(900));
  const Ran ran =
      run(directory,
          "thin p.ply --ratio 9 --equal-counts -o q.ply --indices-out i.npy --owners-out o.csv "
          "--summary s.json");
  CHECK(ran.status == 0);
  CHECK(ran.output.find("chosen: 100 points that stand for 9 each") == 0);
  CHECK(ran.errors == "ccvt: p.ply: only vertices are thinned; dropped: 'face'\n");
  const auto chosen = read_indices(directory / "i.npy");
  REQUIRE(chosen.size() == 100);
  const ReadOptions ids{.columns = {"id", "count"}};
  const auto columns = read_points<double>(directory / "q.ply", ids);
  for (Eigen::Index k = 0; k < 100; ++k) {
    CHECK(columns(0, k) == chosen[static_cast<std::size_t>(k)]);
    CHECK(columns(1, k) == 9);
  }
  const auto owners = read_indices(directory / "o.csv");
  for (std::size_t k = 0; k < 100; ++k) {
    CHECK(owners[static_cast<std::size_t>(chosen[k])] == static_cast<Index>(k));
  }
  // Quiet, other threads: the same.
  const Ran quiet = run(directory, "thin p.ply --sites 100 --equal-counts -q --threads 3 -o r.ply");
  CHECK(quiet.status == 0);
  CHECK(quiet.output.empty());
  CHECK(quiet.errors.empty());
  CHECK(get(directory / "r.ply") == get(directory / "q.ply"));
}

TEST_CASE("thin says what files of another kind do not carry") {
  const TemporaryDirectory directory;
  put(directory / "p.csv", "x,y,z,id\n0,0,0,1\n1,0,0,2\n0,1,0,3\n");
  put(directory / "n.csv", "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n1,0,0,0,0,1\n0,1,0,0,0,1\n");
  const auto told = [&](const std::string& line) {
    const Ran ran = run(directory, "thin " + line + " --sites 2");
    CHECK(ran.status == 0);
    return ran.errors;
  };
  const std::string lost =
      "what its points carry besides coordinates is kept in files of its own kind only, not in ";
  CHECK(told("p.csv -o q.npy") == "ccvt: p.csv: " + lost + ".npy\n");
  CHECK(told("p.csv -o q.ply") == "ccvt: p.csv: " + lost + ".ply\n");
  CHECK(told("n.csv -o q.ply") == "ccvt: n.csv: " + lost + ".ply\n");
  CHECK(told("n.csv -o q.txt").empty());
  CHECK(told("q.ply -o r.csv") == "ccvt: q.ply: " + lost + ".csv\n");  // a count
  CHECK(told("q.npy -o r.csv").empty());
  put(directory / "plain.csv", "0,0\n1,0\n0,1\n");
  CHECK(told("plain.csv -o r.txt") ==
        "ccvt: the last column written says how many points each one stands for; it is no "
        "coordinate\n");
  CHECK(told("plain.csv -o r.npy").empty());
}

TEST_CASE("thin refuses what it cannot do, in one line, and leaves files alone") {
  const TemporaryDirectory directory;
  put(directory / "p.ply", numbered_ply(20));
  const auto refusal = [&](const std::string& line) {
    const Ran ran = run(directory, "thin " + line);
    CHECK(ran.status == 2);
    return ran.errors;
  };
  CHECK(refusal("p.ply -o q.ply") ==
        "ccvt: error: thin: needs --sites or --ratio; see ccvt thin --help\n");
  CHECK(refusal("p.ply --sites 3 --ratio 2 -o q.ply").find("--ratio") != std::string::npos);
  CHECK(refusal("p.ply --ratio .5 -o q.ply").find("--ratio") != std::string::npos);
  CHECK(refusal("p.ply --sites 21 -o q.ply").find("sites: 21 for 20 points") != std::string::npos);
  CHECK(refusal("p.ply --sites 3 -o p.ply").find("name the same file") != std::string::npos);
  CHECK(refusal("p.ply --sites 3 -o q.las").find("unknown extension '.las'") != std::string::npos);
  CHECK(refusal("p.ply --sites 3 --normal-weight -1 -o q.ply").find("--normal-weight") !=
        std::string::npos);
  put(directory / "plain.csv", "1,2,3\n4,5,6\n7,8,9\n");
  CHECK(refusal("plain.csv --sites 2 --normal-weight 1 -o q.ply")
            .find("--normal-weight: plain.csv has no normals") != std::string::npos);
  CHECK(run(directory, "thin plain.csv -q --sites 2 --normal-weight 0 -o q.csv").status == 0);
  CHECK_FALSE(std::filesystem::exists(directory / "q.ply"));
}

#endif

TEST_SUITE_END();

}  // namespace ccvt::test
