#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "support/files.h"
#include "support/message.h"

namespace ccvt::test {
namespace {

template <class Number>
std::string bytes_of(Number number, bool big) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string refusal(const std::filesystem::path& path) {
  return message_of([&] { read_points<float>(path); });
}

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE("PLY: vertices in every encoding, among other elements and properties") {
  const TemporaryDirectory directory;
  // An element before the vertices, with a list; a property and a list among the coordinates.
  const std::string header =
      " 1.0\ncomment made by hand\nobj_info nothing\nelement face 2\n"
      "property list uchar int vertex_indices\nelement vertex 3\nproperty float x\n"
      "property double z\nproperty list uchar short tags\nproperty uchar red\nproperty float y\n"
      "element edge 1\nproperty int a\nend_header\n";
  Points<double> expected(3, 3);
  expected << 1.5, -2, 0.25,  //
      3, 4, 5,                //
      0.1, 1e-300, -7;
  for (const std::string encoding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    CAPTURE(encoding);
    const bool big = encoding == "binary_big_endian";
    std::string data;
    if (encoding == "ascii") {
      data = "3 0 1 2\n0\n1.5 0.1 0 255 3\r\n\n-2 1e-300 2 7 8 0 4\n0.25 -7 1 9 1 5\n17\n";
    } else {
      data = bytes_of<std::uint8_t>(3, big) + bytes_of(0, big) + bytes_of(1, big) +
             bytes_of(2, big) + bytes_of<std::uint8_t>(0, big);
      for (Eigen::Index p = 0; p < 3; ++p) {
        data += bytes_of(static_cast<float>(expected(0, p)), big) + bytes_of(expected(2, p), big) +
                bytes_of(static_cast<std::uint8_t>(p), big);
        for (Eigen::Index t = 0; t < p; ++t) data += bytes_of<std::int16_t>(-300, big);
        data += '\xFF' + bytes_of(static_cast<float>(expected(1, p)), big);
      }
      data += bytes_of(17, big);
    }
    const auto path = put(directory / "p.ply", "ply\nformat " + encoding + header + data);
    const PointsHeader found = inspect_points(path);
    CHECK(found.dimension == 3);
    CHECK(found.count == 3);
    CHECK(found.scalar == ScalarType::float64);
    CHECK(read_points<double>(path) == expected);
    // Cut anywhere before the last vertex ends: refused.
    const std::string whole = get(path);
    for (std::size_t cut = 1; cut < whole.size() - 8; cut += 7) {
      put(directory / "cut.ply", whole.substr(0, cut));
      CHECK(refusal(directory / "cut.ply") != "nothing thrown");
    }
  }
  put(directory / "flat.ply",
      "ply\r\nformat ascii 1.0\r\nelement vertex 2\r\nproperty float x\r\nproperty float y\r\n"
      "end_header\r\n1 2\r\n3 4\r\n");
  CHECK(inspect_points(directory / "flat.ply").scalar == ScalarType::float32);
  CHECK(read_points<float>(directory / "flat.ply") ==
        (Points<float>(2, 2) << 1, 3, 2, 4).finished());
}

TEST_CASE("PLY: what is refused, and why") {
  const TemporaryDirectory directory;
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  struct Case {
    std::string text;
    std::string expected;
  };
  const Case cases[] = {
      {"PLY\n", "start with 'ply'"},
      {"ply\n" + xyz, "not understood"},
      {"ply\nelement vertex 1\n" + xyz + "end_header\n1 2 3\n", "no format"},
      {"ply\nformat binary 1.0\n", "unknown format 'binary'"},
      {"ply\nformat ascii 1.0\n", "before 'end_header'"},
      {"ply\nformat ascii 1.0\nelement face 1\nproperty int a\nend_header\n1\n", "no element"},
      {"ply\nformat ascii 1.0\nelement vertex x\nend_header\n", "'x' is not a number"},
      {"ply\nformat ascii 1.0\nelement vertex 0\n" + xyz + "end_header\n", "no vertices"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nend_header\n", "no properties"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n", "one y"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n", "not understood"},
      {"ply\nformat ascii 1.0\nelement vertex 3000000000\n" + xyz + "end_header\n", "2147483647"},
      {"ply\nformat ascii 1.0\nelement vertex 2000000000\n" + xyz + "end_header\n", "truncated"},
      {"ply\nformat binary_little_endian 1.0\nelement vertex 20\n" + xyz + "end_header\n",
       "truncated"},
      {"ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n1 2\n", "vertex 0"},
      {"ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n1 2 z\n", "'z'"},
      {"ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n1 2 nan\n", "finite"},
      {"ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n1 2 1e300\n", "float32"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.text);
    const std::string message = refusal(put(directory / "p.ply", c.text));
    CAPTURE(message);
    CHECK(message.find(c.expected) != std::string::npos);
    CHECK(message.find("p.ply: ") != std::string::npos);
  }
  CHECK_THROWS_AS(write_points(directory / "q.ply", Points<float>::Zero(3, 3).eval()),
                  InvalidInput);
}

TEST_SUITE_END();

}  // namespace ccvt::test
