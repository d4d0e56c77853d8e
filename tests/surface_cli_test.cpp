// Runs the program itself on surfaces.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "ccvt/io.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

std::string obj_of(const TriangleMesh& mesh) {
  std::string text;
  for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v) {
    text += "v";
    for (Eigen::Index d = 0; d < 3; ++d) text += " " + std::to_string(mesh.vertices(d, v));
    text += " 1 1 " + std::to_string(mesh.vertices(2, v) > 0 ? 3 : 1) + "\n";
  }
  for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {
    text += "f";
    for (Eigen::Index i = 0; i < 3; ++i) text += " " + std::to_string(mesh.triangles(i, t) + 1);
    text += "\n";
  }
  return text;
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("surface: samples, preview, summary; the same for any number of threads") {
  const TemporaryDirectory directory;
  put(directory / "m.obj", obj_of(sphere(32, 16)));
  const std::string line = "surface m.obj --sites 100 --points-per-site 64 --seed 3 ";
  const Ran ran = run(directory, line + "-o a.csv --preview p.png --summary s.json --threads 1");
  CHECK(ran.status == 0);
  CHECK(ran.errors == "");
  CHECK(ran.output.find("544 vertices, 1024 triangles; needs about ") == 0);
  CHECK(ran.output.find("sheets 1, ") != std::string::npos);
  const auto samples = read_points<double>(
      directory / "a.csv",
      {.columns = {"x", "y", "z", "nx", "ny", "nz", "capacity", "triangle", "u", "v"}});
  REQUIRE(samples.cols() == 100);
  CHECK((samples.topRows(3).colwise().norm().array() > 0.97).all());
  CHECK((samples.topRows(3).array() * samples.middleRows(3, 3).array()).colwise().sum().minCoeff() >
        0.95);
  CHECK((samples.row(6).array() == 64).all());
  CHECK(get(directory / "p.png").substr(1, 3) == "PNG");
  const auto json = nlohmann::json::parse(get(directory / "s.json"));
  CHECK(json["command"] == "surface");
  CHECK(json["dimension"] == 6);
  CHECK(run(directory, line + "-o b.csv --threads 3 --quiet").output == "");
  CHECK(get(directory / "b.csv") == get(directory / "a.csv"));
  for (const char* const name : {"c.ply", "c.vtp", "c.vtk", "c.npy"}) {
    CHECK(run(directory, line + "-q --double -o " + name).status == 0);
  }
  // Three times as dense above.
  CHECK(run(directory, line + "-q --density blue --normal-weight 0 -o d.npy").status == 0);
  const auto above = (read_points<double>(directory / "d.npy").row(2).array() > 0).count();
  CHECK(above > 70);
  CHECK(above < 80);
}

TEST_CASE("surface: bad usage and input are refused in one line") {
  const TemporaryDirectory directory;
  put(directory / "m.obj", obj_of(sphere(8, 4)));
  put(directory / "flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const auto errors = [&](const std::string& line) {
    const Ran ran = run(directory, line);
    CHECK(ran.status == 2);
    CHECK(ran.output.empty());
    CHECK(std::count(ran.errors.begin(), ran.errors.end(), '\n') == 1);
    return ran.errors;
  };
  const auto mentions = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  CHECK(mentions(errors("surface m.obj -o s.ply"), "--sites"));
  CHECK(mentions(errors("surface none.obj --sites 9 -o s.ply"), "none.obj: there is no such file"));
  CHECK(mentions(errors("surface m.obj --sites 9 -o s.obj"), "s.obj"));
  CHECK(mentions(errors("surface m.obj --sites 9 -o s.ply --density heat"), "no density 'heat'"));
  CHECK(mentions(errors("surface m.obj --sites 9 -o s.ply --normal-weight -1"), "--normal-weight"));
  CHECK(mentions(errors("surface m.obj --sites 9 -o s.ply --up y"), "--preview"));
  CHECK(mentions(errors("surface flat.obj -q --sites 9 -o s.ply"),
                 "flat.obj: mesh: none of its 1 triangles has an area; needs one"));
  CHECK(mentions(errors("surface m.obj --sites 9 -o m.obj"), "m.obj"));
  CHECK(directory.entries() == 2);  // nothing was written
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
