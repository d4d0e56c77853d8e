// Runs the program itself on volumes.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "support/files.h"
#include "support/npy.h"
#include "support/process.h"
#include "support/volumes.h"

namespace ccvt::test {
namespace {

// 16 x 16 x 8 voxels of 1 x 2 x 3 mm; bright where i is 8 and above.
std::string half_bright() {
  std::vector<std::int16_t> values;
  for (int cell = 0; cell < 16 * 16 * 8; ++cell) {
    values.push_back(static_cast<std::int16_t>(cell % 16 < 8 ? -100 : 300));
  }
  return nifti1({16, 16, 8}, 4, 16) + bytes_of_values(values);
}

// The same cells: 1, but NaN in the sixth.
std::string with_nan() {
  std::vector<float> values(16 * 16 * 8, 1.0F);
  values[5] = NAN;
  return nifti1({16, 16, 8}, 16, 32) + bytes_of_values(values);
}

// The same cells: the layer that they are in.
std::string labels() {
  std::vector<std::int16_t> values;
  for (int cell = 0; cell < 16 * 16 * 8; ++cell) {
    values.push_back(static_cast<std::int16_t>(cell / 256 % 4));
  }
  return nifti1({16, 16, 8}, 4, 16) + bytes_of_values(values);
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("volume: samples, preview, summary; the same for any number of threads") {
  const TemporaryDirectory directory;
  put(directory / "v.nii.gz", gzipped(half_bright()));
  const std::string line =
      "volume v.nii.gz --sites 60 --points-per-site 32 --map threshold:0 --seed 5 ";
  const Ran ran = run(directory, line + "-o a.csv --preview p.png --summary s.json --threads 1");
  CHECK(ran.status == 0);
  CHECK(ran.errors == "");
  CHECK(ran.output.substr(0, 12) == "needs about ");
  const auto samples = read_points<float>(
      directory / "a.csv", {.columns = {"x", "y", "z", "radius", "capacity", "weight"}});
  REQUIRE(samples.cols() == 60);
  CHECK(samples.rows() == 6);
  CHECK(samples.row(0).minCoeff() > 7);
  CHECK(samples.row(0).maxCoeff() < 15.5F);
  CHECK(samples.row(2).maxCoeff() > 15);  // in millimetres
  CHECK((samples.row(4).array() == 32).all());
  CHECK(get(directory / "p.png").substr(1, 3) == "PNG");
  const auto json = nlohmann::json::parse(get(directory / "s.json"));
  CHECK(json["command"] == "volume");
  CHECK(json["termination"] == "stable");
  CHECK(json["capacity_error"] == 0);
  CHECK(run(directory, line + "-o b.csv --threads 2 --quiet").output == "");
  CHECK(get(directory / "b.csv") == get(directory / "a.csv"));
  for (const char* const name : {"c.ply", "c.vtp", "c.vtk", "c.npy"}) {
    CHECK(run(directory, line + "-q --double -o " + name).status == 0);
  }
}

TEST_CASE("volume: masks, inversion, raw and .npy files") {
  const TemporaryDirectory directory;
  put(directory / "v.nii", half_bright());
  std::vector<std::uint8_t> mask(16 * 16 * 8, 0);
  for (std::size_t i = 0; i < 16 * 16; ++i) mask[i] = 200;  // the lowest layer
  put(directory / "m.nii", nifti1({16, 16, 8}, 2, 8) + bytes_of_values(mask));
  const std::string line = "volume v.nii --sites 20 --points-per-site 16 -q -o s.npy ";
  CHECK(run(directory, line + "--map window:0,100 --mask m.nii").status == 0);
  CHECK(read_points<float>(directory / "s.npy").row(2).maxCoeff() < 3);
  CHECK(run(directory, line + "--invert").status == 0);
  CHECK(read_points<float>(directory / "s.npy").row(0).maxCoeff() < 8);

  put(directory / "v.raw", bytes_of_values(mask));
  CHECK(run(directory,
            "volume v.raw --shape 16,16,8 --type uint8 --spacing 1,1,2.5 --origin -5,0,100 "
            "--sites 20 -q -o s.npy")
            .status == 0);
  const auto sites = read_points<float>(directory / "s.npy");
  CHECK(sites.row(0).minCoeff() > -5.5F);
  CHECK(sites.row(0).maxCoeff() < 10.5F);
  CHECK(sites.row(2).minCoeff() > 98.7F);
  CHECK(sites.row(2).maxCoeff() < 102.6F);
}

TEST_CASE("volume: a mask may store its axes in another order, or say less of its place") {
  const TemporaryDirectory directory;
  // Samples where the second index, j, is 2 and above, of 4, 4 and 4 cells, and of 3, 4 and 5.
  for (const std::array<int, 3> n : {std::array{4, 4, 4}, std::array{3, 4, 5}}) {
    std::string first_fastest;
    std::string last_fastest;
    for (int k = 0; k < n[2]; ++k) {
      for (int j = 0; j < n[1]; ++j)
        first_fastest += std::string(static_cast<std::size_t>(n[0]), j < 2 ? '\0' : '\1');
    }
    for (int i = 0; i < n[0]; ++i) {
      for (int j = 0; j < n[1]; ++j)
        last_fastest += std::string(static_cast<std::size_t>(n[2]), j < 2 ? '\0' : '\1');
    }
    const std::string shape = "(" + std::to_string(n[0]) + ", " + std::to_string(n[1]) + ", " +
                              std::to_string(n[2]) + ")";
    const auto nifti = [&](const std::string& data) {
      return nifti1({n[0], n[1], n[2]}, 2, 8) + data;  // spacings 1, 2, 3, from 0
    };
    const std::string ones(first_fastest.size(), '\1');
    put(directory / "v_c.npy", npy_file("|u1", shape, ones));
    put(directory / "v_f.npy", npy_file("|u1", shape, ones, true));
    put(directory / "v.nii", nifti(ones));
    put(directory / "v.raw", ones);
    put(directory / "m_c.npy", npy_file("|u1", shape, last_fastest));
    put(directory / "m_f.npy", npy_file("|u1", shape, first_fastest, true));
    put(directory / "m.nii", nifti(first_fastest));
    put(directory / "m.raw", first_fastest);
    const std::string cells = " --type uint8 --shape " + std::to_string(n[0]) + "," +
                              std::to_string(n[1]) + "," + std::to_string(n[2]);
    const std::string place = " --spacing 1,2,3 --origin 0,0,0";
    for (const std::string volume : {"v_c.npy", "v_f.npy", "v.nii", "v.raw"}) {
      for (const std::string mask : {"m_c.npy", "m_f.npy", "m.nii", "m.raw"}) {
        CAPTURE(volume + " " + mask);
        std::string line = "volume --sites 20 --points-per-site 16 -q -o s.npy " + volume;
        if (volume == "v.raw" || mask == "m.raw") line += cells;
        if (volume != "v.nii") line += place;
        const Ran ran = run(directory, line + " --mask " + mask);
        CHECK(ran.errors == "");
        REQUIRE(ran.status == 0);
        const auto sites = read_points<float>(directory / "s.npy");
        CHECK(sites.row(1).minCoeff() > 3);  // in millimetres
        CHECK(sites.row(1).maxCoeff() < 7);
        CHECK(sites.row(0).minCoeff() < 0.5F);
        CHECK(sites.row(2).maxCoeff() > 6);
      }
    }
  }
}

TEST_CASE("volume: a mask may store its axes in any order, and from either end") {
  const TemporaryDirectory directory;
  constexpr std::array kCells = {3, 4, 5};
  constexpr std::array kSpacing = {1, 2, 3};
  const auto inside = [](const std::array<int, 3>& cell) {
    return (7 * cell[0] + 5 * cell[1] * cell[2] + cell[2]) % 3 == 0;
  };
  put(directory / "v.nii", nifti1({3, 4, 5}, 2, 8) + std::string(60, '\1'));
  std::string expected;
  std::array<int, 3> axes = {0, 1, 2};
  do {
    for (int flips = 0; flips < 8; ++flips) {
      CAPTURE(axes);
      CAPTURE(flips);
      const auto reversed = [&](int axis) { return (flips >> axis & 1) != 0; };
      std::string sizes;
      std::string directions;
      for (const int axis : axes) {
        sizes += " " + std::to_string(kCells.at(static_cast<std::size_t>(axis)));
        std::array<int, 3> step{};
        step.at(static_cast<std::size_t>(axis)) =
            (reversed(axis) ? -1 : 1) * kSpacing.at(static_cast<std::size_t>(axis));
        directions += " (" + std::to_string(step[0]) + "," + std::to_string(step[1]) + "," +
                      std::to_string(step[2]) + ")";
      }
      std::string origin;
      for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        origin += (axis > 0 ? "," : "") +
                  std::to_string(reversed(axis) ? kSpacing.at(at) * (kCells.at(at) - 1) : 0);
      }
      std::string data;
      const auto cells = [&](std::size_t which) {
        return kCells.at(static_cast<std::size_t>(axes.at(which)));
      };
      for (int c = 0; c < cells(2); ++c) {
        for (int b = 0; b < cells(1); ++b) {
          for (int a = 0; a < cells(0); ++a) {
            std::array<int, 3> cell{};
            for (std::size_t which = 0; which < 3; ++which) {
              const int along = std::array{a, b, c}.at(which);
              const int axis = axes.at(which);
              cell.at(static_cast<std::size_t>(axis)) =
                  reversed(axis) ? cells(which) - 1 - along : along;
            }
            data += inside(cell) ? '\1' : '\0';
          }
        }
      }
      put(directory / "m.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nspace dimension: 3\nsizes:" +
                                    sizes + "\nspace directions:" + directions +
                                    "\nspace origin: (" + origin + ")\nencoding: raw\n\n" + data);
      const Ran ran =
          run(directory, "volume v.nii --mask m.nrrd --sites 12 --points-per-site 16 -q -o s.npy");
      CHECK(ran.errors == "");
      REQUIRE(ran.status == 0);
      if (expected.empty()) expected = get(directory / "s.npy");
      CHECK(get(directory / "s.npy") == expected);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
}

TEST_CASE("volume: a raw mask of another type, beside a raw volume and another") {
  const TemporaryDirectory directory;
  std::vector<float> values(6 * 6 * 6, 1.0F);
  std::vector<std::uint16_t> mask(values.size(), 0);
  for (std::size_t i = 0; i < 36; ++i) mask[i] = 1;  // the lowest layer
  put(directory / "v.raw", bytes_of_values(values));
  put(directory / "v.npy", npy_file("<f4", "(6, 6, 6)", bytes_of_values(values), true));
  put(directory / "m.raw", bytes_of_values(mask, true));
  for (const std::string volume : {"v.raw --type float32", "v.npy"}) {
    const Ran ran = run(directory, "volume " + volume + " --shape 6,6,6 --mask m.raw --mask-type " +
                                       "uint16be --sites 20 -q -o s.npy");
    CHECK(ran.errors == "");
    REQUIRE(ran.status == 0);
    CHECK(read_points<float>(directory / "s.npy").row(2).maxCoeff() < 0.5F);
  }
}

TEST_CASE("volume: labels of a mask, a mask with NaN, constant cells") {
  const TemporaryDirectory directory;
  put(directory / "v.nii", half_bright());
  put(directory / "l.nii", labels());
  put(directory / "nan.nii", with_nan());
  const std::string line = "volume v.nii --map window:-200,300 --sites 60 -q -o s.npy ";
  const auto layers = [&](const std::string& arguments) {
    std::vector<int> counts(8);
    CHECK(run(directory, line + arguments).status == 0);
    const auto sites = read_points<double>(directory / "s.npy");
    for (Eigen::Index s = 0; s < 60; ++s) {
      ++counts.at(static_cast<std::size_t>(sites(2, s) / 3 + 0.5));
    }
    return counts;
  };
  const auto several = layers("--mask l.nii --label 1,3 --summary s.json");
  for (const std::size_t layer : {0U, 2U, 4U, 6U}) CHECK(several[layer] == 0);
  for (const std::size_t layer : {1U, 3U, 5U, 7U}) CHECK(several[layer] > 5);
  const auto json = nlohmann::json::parse(get(directory / "s.json"));
  CHECK(json["put_back"]["sites"].is_number_integer());
  CHECK(json["put_back"]["farthest"].is_number());
  CHECK(json["warnings"].empty());
  const auto others = layers("--mask l.nii");
  CHECK(others[0] + others[4] == 0);
  CHECK(others[2] > 2);
  CHECK(run(directory, "volume nan.nii --mask nan.nii --sites 20 -q -o t.npy").status == 0);

  // Constant cells keep what is dim as dim as it is up to the border between columns 7 and 8.
  const auto in_column = [&](const std::string& interpolation) {
    CHECK(run(directory,
              "volume v.nii --map window:-101,300 --sites 2000 --points-per-site 1 -q "
              "-o s.npy --interpolation " +
                  interpolation)
              .status == 0);
    const auto sites = read_points<double>(directory / "s.npy");
    return (sites.row(0).array() > 7.05 && sites.row(0).array() < 7.45).count();
  };
  CHECK(in_column("constant") < 5);
  CHECK(in_column("linear") > 10);  // 25 expected
}

TEST_CASE("volume: far from the origin, as near it") {
  const TemporaryDirectory directory;
  put(directory / "v.raw", std::string(16 * 16 * 16, '\1'));
  const std::string line =
      "volume v.raw --shape 16,16,16 --type uint8 --spacing .1,.1,.1 --points-per-site 16 "
      "--sites 500 -q ";
  CHECK(run(directory, line + "-o near.ply").status == 0);
  CHECK(run(directory, line + "--origin 500000,5400000,1000 -o far.ply").status == 0);
  const auto near = read_points<double>(directory / "near.ply");
  const auto far = read_points<double>(directory / "far.ply");
  const Eigen::Vector3d origin(500000, 5400000, 1000);
  CHECK(((far.topRows(3).colwise() - origin) - near.topRows(3)).cwiseAbs().maxCoeff() < 1e-4);
}

TEST_CASE("tessellate warns of float points that are too coarse where they are") {
  const TemporaryDirectory directory;
  const Points<float> near = sample_uniform<float>(Box::unit(2), 3200, 3);
  write_points(directory / "near.npy", near);
  write_points(directory / "far.npy", Points<float>(near.array() + 5e5F));
  write_points(directory / "wide.npy", Points<double>(near.cast<double>().array() + 5e5));
  const auto errors = [&](const std::string& arguments) {
    const Ran ran = run(directory, arguments);
    CHECK(ran.status == 0);
    return ran.errors;
  };
  CHECK(errors("tessellate near.npy --sites 50 -o s.npy") == "");
  CHECK(errors("tessellate wide.npy --sites 50 -o s.npy") == "");
  CHECK(errors("tessellate far.npy --sites 50 -q -o s.npy") == "");
  const std::string start = "ccvt: warning: points: coordinate ";
  const std::string told = errors("tessellate far.npy --sites 50 -o s.npy");
  CHECK(told.substr(0, start.size()) == start);
  CHECK(std::count(told.begin(), told.end(), '\n') == 1);
  CHECK(errors("quantize far.npy --codewords 50 -o s.npy").find("ccvt: warning: vectors: ") == 0);
  CHECK(errors("quantize wide.npy --codewords 50 -o s.npy") == "");
  const std::string box = " --box 500000 500000 500001 500001 -o report";
  CHECK(errors("analyze wide.npy" + box) == "");
  CHECK(errors("analyze far.npy" + box).find("ccvt: warning: far.npy: points: coordinate") == 0);
}

TEST_CASE("volume: mistakes get one line, status 2 and no file") {
  const TemporaryDirectory directory;
  put(directory / "vast.raw", "x");
  put(directory / "v.nii", half_bright());
  put(directory / "m.nii", nifti1({16, 16, 7}, 2, 8) + std::string(16 * 16 * 7, '\1'));
  std::string moved = nifti1({16, 16, 8}, 2, 8) + std::string(16 * 16 * 8, '\1');
  put_at(moved, 80, 1.5F);
  put(directory / "moved.nii", moved);
  put(directory / "turned.nii", nifti1({16, 8, 16}, 2, 8) + std::string(16 * 16 * 8, '\1'));
  put(directory / "lps.nrrd",
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 8\nencoding: raw\n"
      "space: left-posterior-superior\nspace directions: (-1,0,0) (0,-2,0) (0,0,3)\n"
      "space origin: (0,0,0)\n\n" +
          std::string(16 * 16 * 8, '\1'));
  const auto turned_nrrd = [](const std::string& sizes, const std::string& directions) {
    return "NRRD0004\ntype: uint8\ndimension: 3\nsizes: " + sizes +
           "\nencoding: raw\nspace: right-anterior-superior\nspace directions: " + directions +
           "\nspace origin: (0,0,0)\n\n" + std::string(16 * 8 * 4, '\1');
  };
  put(directory / "t40.nrrd", turned_nrrd("16 8 4", "(.77,.64,0) (-.64,.77,0) (0,0,1)"));
  put(directory / "t50.nrrd", turned_nrrd("8 16 4", "(.64,.77,0) (-.77,.64,0) (0,0,1)"));
  put(directory / "tiny.nrrd",
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n"
      "spacings: 1e-120 1e-120 1e-120\n\n12345678");
  put(directory / "v.raw", "12345678");
  put(directory / "nan.nii", with_nan());
  put(directory / "l.nii", labels());
  put(directory / "zero.nii", nifti1({16, 16, 8}, 2, 8) + std::string(16 * 16 * 8, '\0'));
  const std::size_t before = directory.entries();
  const auto check = [&](const std::string& arguments, const std::string& part) {
    const Ran ran = run(directory, "volume --sites 5 -q -o s.ply " + arguments);
    CAPTURE(ran.errors);
    CHECK(ran.status == 2);
    CHECK(std::count(ran.errors.begin(), ran.errors.end(), '\n') == 1);
    CHECK(ran.errors.find(part) != std::string::npos);
  };
  check("v.nii",
        "v.nii: has values from -100 to 300, but a density is not negative; choose which "
        "values matter with --map window:LO,HI");
  check("v.nii --map gamma:2", "--map window:LO,HI");
  check("nan.nii", "nan.nii: value 5 is nan; leave such cells out with --mask FILE");
  check("nan.nii --map gamma:2", "nan.nii: value 5 is nan; leave such cells out with --mask FILE");
  check("v.nii --mask l.nii --label 5,6", "l.nii: no cell has one of the labels 5, 6");
  check("v.nii --mask l.nii --label 5,", "'5,' has an empty entry");
  check("v.nii --mask zero.nii", "zero.nii: no cell is anything but 0");
  check("v.nii --label 5", "--label: needs --mask");
  check("v.nii --mask-type uint8", "--mask-type: needs a .raw file for --mask");
  check("v.nii --mask l.nii --mask-type uint8", "--mask-type: needs a .raw file for --mask");
  check("v.nii --interpolation cubic", "'cubic' is not one of constant, linear");
  check("none.nii", "there is no such file");
  check("vast.raw --shape 100000,100000,100000 --type uint8",
        "vast.raw: 1000000000000000 cells would need 909.5 TiB of memory, but this machine has ");
  check("v.nii --map window:5,5", "LO less than HI");
  check("v.nii --map window:5", "needs 2, with commas");
  check("v.nii --map gamma:0", "above 0");
  check("v.nii --map log", "'log' is not one of linear");
  check("v.nii --map threshold:1000", "all 2048 densities are 0");
  check("v.nii --mask m.nii",
        "m.nii: has 16 x 16 x 7 cells along x, y and z, but v.nii has 16 x 16 x 8\n");
  check("v.nii --mask turned.nii",
        "has 16 x 8 x 16 cells along x, y and z, but v.nii has 16 x 16 x 8: they say otherwise "
        "where their axes point");
  check("t40.nrrd --mask t50.nrrd", "t50.nrrd: its axes are turned against those of t40.nrrd");
  check("v.nii --mask lps.nrrd",
        "lps.nrrd: its cells are where those of v.nii are if x and y run the other way");
  check("v.nii --mask moved.nii", "its cells are not where those of v.nii are");
  check("v.nii --spacing 1,1,1", "says its spacing and origin itself");
  check("v.nii --preview p.jpg", "must be .png");
  check("v.raw", "needs a shape of 3 numbers and a type");
  check("v.raw --shape 2,2,2 --type int12", "'int12' is not one of int8");
  check("v.raw --shape 2,2 --type int8", "needs 3, with commas");
  check("v.raw --shape 2,2,3 --type uint8", "is truncated");
  check("v.raw --shape 2,0,3 --type uint8", "of at least 1");
  check("v.raw --shape 2,2,2 --type uint8 --spacing 1,0,1", "of at least 1e-30");
  check("v.raw --shape 2,2,2 --type uint8 --spacing 1,1e200,1", "--spacing: '1e200' is not");
  check("v.raw --shape 2,2,2 --type uint8 --spacing 1,1e-120,1", "--spacing: '1e-120' is not");
  check("tiny.nrrd", "or flat: the volume of a cell is 0");
  check("v.raw --shape 2,2,2 --type uint8 --origin 1e16,0,0", "along axis 0 apart");
  check(
      "v.raw --shape 2,2,2 --type uint8 --origin 0,1e20,0",
      "v.raw: has its origin at (0, 1e+20, 0), too far away to tell its cells along axis 1 apart");
  CHECK(directory.entries() == before);
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
