// Readers of meshes.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "ccvt/surface.h"
#include "support/files.h"
#include "support/message.h"
#include "support/npy.h"

using ccvt::Index;
using ccvt::read_mesh;
using ccvt::TriangleMesh;
using namespace ccvt::test;

namespace {

/// A square in the plane z = 2, as one face and as two triangles, with things that are skipped.
const char* const kAscii =
    "ply\nformat ascii 1.0\ncomment a square\nelement material 1\nproperty list uchar int tags\n"
    "property float shine\n"
    "element vertex 4\nproperty float x\nproperty double y\nproperty list uchar short skipped\n"
    "property uchar quality\nproperty float z\n"
    "element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\n"
    "end_header\n"
    "3 1 2 3 .5\n"
    "0 0 0 7 2\n1 0 1 -5 0 2\n1 1 0 3 2\n\n0 1 2 9 9 1 2\n"
    "255 4 0 1 2 3\n0 3 2 1 0\n";

std::string binary(bool big) {
  const auto f = [big](std::vector<float> v) { return number_bytes(v, big); };
  const auto d = [big](std::vector<double> v) { return number_bytes(v, big); };
  const auto s = [big](std::vector<std::int16_t> v) { return number_bytes(v, big); };
  const auto i = [big](std::vector<std::int32_t> v) { return number_bytes(v, big); };
  const std::string text = kAscii;
  std::string header = text.substr(0, text.find("end_header\n") + 11);
  header.replace(header.find("ascii"), 5, big ? "binary_big_endian" : "binary_little_endian");
  std::string bytes = header + "\x03" + i({1, 2, 3}) + f({.5F});
  bytes += f({0}) + d({0}) + std::string("\0\x07", 2) + f({2});
  bytes += f({1}) + d({0}) + "\x01" + s({-5}) + std::string("\0", 1) + f({2});
  bytes += f({1}) + d({1}) + std::string("\0\x03", 2) + f({2});
  bytes += f({0}) + d({1}) + "\x02" + s({9, 9}) + "\x01" + f({2});
  bytes += "\xFF\x04" + i({0, 1, 2, 3}) + std::string("\0\x03", 2) + i({2, 1, 0});
  return bytes;
}

void check_square(const TriangleMesh& mesh) {
  CHECK(mesh.vertices == Eigen::MatrixXd{{0, 1, 1, 0}, {0, 0, 1, 1}, {2, 2, 2, 2}});
  const Eigen::Matrix<Index, 3, 3> triangles{{0, 0, 2}, {1, 2, 1}, {2, 3, 0}};
  CHECK(mesh.triangles == triangles);
}

const char* const kObj =
    "# a square\nmtllib x.mtl\nv 0 0 2\nv 1 0 2 0.5\nvt 0 0\nvn 0 0 1\n"
    "v\t1 1 2 \r\nv 0 1 2 # the last one\ng all\nusemtl red\n"
    "f 1/1/1 2//1 \\\n3/1 4\ns off\nf -2 -3 \\ \r\n\\\n-4/1\n";

}  // namespace

TEST_SUITE_BEGIN("mesh");

TEST_CASE("meshes in PLY files of every encoding") {
  const TemporaryDirectory directory;
  for (const std::string& bytes : {std::string(kAscii), binary(false), binary(true)}) {
    put(directory / "m.ply", bytes);
    const TriangleMesh mesh = read_mesh(directory / "m.ply");
    check_square(mesh);
    CHECK(mesh.density.empty());
    CHECK(read_mesh(directory / "m.ply", "quality").density == std::vector<double>{7, 0, 3, 1});
  }
  // Faces may come first.
  put(directory / "m.ply",
      "ply\nformat ascii 1.0\nelement face 1\nproperty list int uint vertex_index\nelement vertex "
      "3\nproperty int x\nproperty int y\nproperty int z\nend_header\n3 0 2 1\n0 0 0\n1 0 0\n0 1 "
      "0\n");
  CHECK(read_mesh(directory / "m.ply").triangles(1, 0) == 2);
}

TEST_CASE("meshes in OBJ files") {
  const TemporaryDirectory directory;
  put(directory / "m.OBJ", kObj);
  check_square(read_mesh(directory / "m.OBJ"));
  // Faces before their vertices, colours, a long face, no line feed at the end.
  std::string text = "f 1 2 3\nf";
  for (int i = 1; i <= 30000; ++i) text += " " + std::to_string(i) + "/7/8";
  text += "\n";
  for (int i = 0; i < 30000; ++i) {
    text += "v " + std::to_string(i) + " 0 " + std::to_string(i % 2) + " .25 .5 " +
            std::to_string(i) + (i < 29999 ? "\n" : "");
  }
  put(directory / "m.obj", text);
  const TriangleMesh mesh = read_mesh(directory / "m.obj", "blue");
  CHECK(mesh.vertices.cols() == 30000);
  CHECK(mesh.triangles.cols() == 29999);
  CHECK(mesh.triangles(2, 29998) == 29999);
  CHECK(mesh.density[17] == 17);
  CHECK(read_mesh(directory / "m.obj", "red").density[5] == 0.25);
  CHECK(read_mesh(directory / "m.obj").density.empty());
}

TEST_CASE("bad PLY meshes are refused, with the place") {
  const TemporaryDirectory directory;
  const auto path = directory / "m.ply";
  const auto refusal = [&](const std::string& from, const std::string& to,
                           const std::string& density = "") {
    std::string text = kAscii;
    REQUIRE(text.find(from) != std::string::npos);
    put(path, text.replace(text.find(from), from.size(), to));
    const std::string message = message_of([&] { (void)read_mesh(path, density); });
    CHECK(message.substr(0, path.string().size() + 2) == path.string() + ": ");
    return message.substr(std::min(message.size(), path.string().size() + 2));
  };
  CHECK(refusal("0 3 2 1 0", "0 3 2 4 0") ==
        "face 1: corner 1 is vertex 4; vertices have the numbers 0 to 3");
  CHECK(refusal("0 3 2 1 0", "0 3 2 -1 0") ==
        "face 1: corner 1 is vertex -1; vertices have the numbers 0 to 3");
  CHECK(refusal("0 3 2 1 0", "0 3 2 .5 0") ==
        "face 1: corner 1 is vertex 0.5; vertices have the numbers 0 to 3");
  CHECK(refusal("0 3 2 1 0", "0 2 2 1") == "face 1: has 2 corners; needs at least 3");
  CHECK(refusal("0 3 2 1 0", "0 3 2 1") == "face 1: has too few numbers");
  CHECK(refusal("1 0 1 -5 0 2", "1 nan 1 -5 0 2").find("'nan'") != std::string::npos);
  CHECK(refusal("element vertex", "element vortex") == "has no element 'vertex'");
  CHECK(refusal("element face", "element fac") == "has no element 'face': it holds no surface");
  CHECK(refusal("vertex_indices", "corners") ==
        "faces need the list vertex_indices or vertex_index");
  CHECK(refusal("float z", "float w") == "vertices need one x, one y and one z");
  CHECK(refusal("comment", "comment", "heat") ==
        "vertices have no property 'heat'; they have x, y, quality, z");
  CHECK(refusal("comment", "comment", "y") == "the property 'y' is a coordinate, and no density");
  CHECK(refusal("1 1 0 3 2", "1 1 0 -3 2", "quality") ==
        "vertex 2: the density is -3; must be finite and not negative");
  CHECK(refusal("element face 2", "element face 0") == "has no face items");
  CHECK(refusal("element face 2", "element face 20000").find("is truncated") == 0);
  put(directory / "m.stl", "solid");
  CHECK(message_of([&] {
          (void)read_mesh(directory / "m.stl");
        }).find("unknown extension '.stl'; meshes are read from .ply or .obj") !=
        std::string::npos);
}

TEST_CASE("bad OBJ meshes are refused, with the line") {
  const TemporaryDirectory directory;
  const auto path = directory / "m.obj";
  const auto refusal = [&](const std::string& text, const std::string& density = "") {
    put(path, text);
    const std::string message = message_of([&] { (void)read_mesh(path, density); });
    return message.substr(std::min(message.size(), path.string().size() + 2));
  };
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK(refusal(three + "f 1 2 4\n") == "line 4: a face has vertex 4, but there are 3");
  CHECK(refusal(three + "f 1 2 0\n").find("line 4: a face has vertex 0, but") == 0);
  CHECK(refusal(three + "f 1 2 -4\n").find("line 4: a face has vertex -4, but") == 0);
  CHECK(refusal(three + "f 1 2\n") == "line 4: a face has 2 corners; needs at least 3");
  CHECK(refusal(three + "f 1 2 a\n") ==
        "line 4: 'a' is not a corner of a face: i, i/j, i//k or i/j/k");
  CHECK(refusal(three + "f 1 2 3/1/1/1\n").find("line 4: '3/1/1/1' is not") == 0);
  CHECK(refusal(three) == "has no faces: it holds no surface");
  CHECK(refusal("g x\n") == "has no vertices");
  CHECK(refusal("v 0 0\n") == "line 1: a vertex has 2 numbers; needs x, y and z");
  CHECK(refusal("v 0 0 inf\n").find("line 1: 'inf'") == 0);
  CHECK(refusal(three + "f 1 2 3\n", "red") ==
        "line 1: a vertex has 3 numbers; for a density it needs x, y, z, red, green and blue");
  CHECK(refusal("v 0 0 0 1 -1 1\n", "green") == "line 1: a density is -1; must not be negative");
  CHECK(refusal(three, "heat") == "has no density 'heat'; of OBJ files it is red, green or blue");
  CHECK(refusal(three + "v 1e16 0 0\nf 1 3 4\n").find("mesh: its triangles extend over 1e+16") ==
        0);
}

TEST_CASE("meshes that are cut or damaged anywhere are read or refused") {
  const TemporaryDirectory directory;
  const std::string files[] = {kAscii, binary(false), binary(true), kObj};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto path = directory / (k < 3 ? "m.ply" : "m.obj");
    const std::string& whole = files[k];
    for (std::size_t cut = 0; cut < whole.size(); ++cut) {
      put(path, whole.substr(0, cut));
      const std::string message = message_of([&] { (void)read_mesh(path); });
      // Of text the last numbers may be cut short, or a face of more triangles than needed.
      if (k == 1 || k == 2) CHECK(message.find("m.ply: ") != std::string::npos);
      for (const char changed : {'\0', '\xFF', '9', '\n'}) {
        std::string damaged = whole;
        damaged[cut] = changed;
        put(path, damaged);
        (void)message_of([&] { read_mesh(path).validate(); });
      }
    }
  }
}

TEST_SUITE_END();
