// Every kind of array that NumPy writes, as points, as whole numbers and as volumes.
#include "io/npy.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/volume.h"
#include "support/files.h"
#include "support/message.h"
#include "support/npy.h"

namespace ccvt::test {
namespace {

/// 1, 2, … as Stored: (x, y) of three points, one after the other.
template <class Stored>
std::vector<Stored> one_to_six() {
  return {Stored(1), Stored(2), Stored(3), Stored(4), Stored(5), Stored(6)};
}

Points<double> expected_points() { return (Points<double>(2, 3) << 1, 3, 5, 2, 4, 6).finished(); }

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE("half precision numbers stand for what IEEE 754 says") {
  CHECK(io::float_of_half(0x0000) == 0);
  CHECK(std::signbit(io::float_of_half(0x8000)));
  CHECK(io::float_of_half(0x3C00) == 1);
  CHECK(io::float_of_half(0xC500) == -5);
  CHECK(io::float_of_half(0x3555) == 1365.0F / 4096);
  CHECK(io::float_of_half(0x7BFF) == 65504);
  CHECK(io::float_of_half(0x0400) == std::ldexp(1.0F, -14));
  CHECK(io::float_of_half(0x0001) == std::ldexp(1.0F, -24));
  CHECK(io::float_of_half(0x7C00) == std::numeric_limits<float>::infinity());
  CHECK(io::float_of_half(0xFC00) == -std::numeric_limits<float>::infinity());
  CHECK(std::isnan(io::float_of_half(0x7E00)));
}

TEST_CASE_TEMPLATE(".npy: points of every type and byte order", Scalar, float, double) {
  const TemporaryDirectory directory;
  const auto check = [&](const std::string& descr, const auto& numbers, ScalarType scalar) {
    for (const char order : {'<', '>'}) {
      const bool one_byte = sizeof(numbers[0]) == 1;
      if (one_byte && order == '>') continue;
      const std::string full = (one_byte ? '|' : order) + descr;
      CAPTURE(full);
      const auto path =
          put(directory / "p.npy", npy_file(full, "(3, 2)", number_bytes(numbers, order == '>')));
      CHECK(read_points<Scalar>(path) == expected_points().cast<Scalar>());
      CHECK(inspect_points(path).scalar == scalar);
      CHECK(inspect_points(path).dimension == 2);
      CHECK(inspect_points(path).count == 3);
    }
  };
  check("i1", one_to_six<std::int8_t>(), ScalarType::float32);
  check("u1", one_to_six<std::uint8_t>(), ScalarType::float32);
  check("i2", one_to_six<std::int16_t>(), ScalarType::float32);
  check("u2", one_to_six<std::uint16_t>(), ScalarType::float32);
  check("i4", one_to_six<std::int32_t>(), ScalarType::float64);
  check("u4", one_to_six<std::uint32_t>(), ScalarType::float64);
  check("i8", one_to_six<std::int64_t>(), ScalarType::float64);
  check("u8", one_to_six<std::uint64_t>(), ScalarType::float64);
  check("f2", std::vector<std::uint16_t>{0x3C00, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600},
        ScalarType::float32);
  check("f4", one_to_six<float>(), ScalarType::float32);
  check("f8", one_to_six<double>(), ScalarType::float64);
  // NumPy writes True as 1, and takes any other byte for it too.
  put(directory / "b.npy", npy_file("|b1", "(3, 1)", std::string("\1\0\7", 3)));
  CHECK(read_points<Scalar>(directory / "b.npy") == (Points<Scalar>(1, 3) << 1, 0, 1).finished());
}

TEST_CASE_TEMPLATE(".npy: Fortran order is the same points", Scalar, float, double) {
  const TemporaryDirectory directory;
  const std::vector<double> columns = {1, 3, 5, 2, 4, 6};
  for (const bool big : {false, true}) {
    const auto path = put(directory / "p.npy", npy_file(big ? ">f8" : "<f8", "(3, 2)",
                                                        number_bytes(columns, big), true));
    CHECK(read_points<Scalar>(path) == expected_points().cast<Scalar>());
  }
  // More points than are read at once, and an entry that is named by its place in the array.
  constexpr std::size_t count = 100'000;
  std::vector<float> many(3 * count);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<float>(i);
  const auto large =
      put(directory / "l.npy", npy_file("<f4", "(100000, 3)", number_bytes(many), true));
  const auto points = read_points<Scalar>(large);
  CHECK(points(0, 77'777) == 77'777);
  CHECK(points(2, 99'999) == 299'999);
  many[count + 5] = std::numeric_limits<float>::quiet_NaN();
  put(directory / "l.npy", npy_file("<f4", "(100000, 3)", number_bytes(many), true));
  CHECK(contains(message_of([&] { read_points<Scalar>(large); }),
                 "row 5, column 1: nan is not finite"));
}

TEST_CASE(".npy: whole numbers that a float does not hold are refused by name") {
  const TemporaryDirectory directory;
  const auto message = [&](const auto& numbers, const std::string& descr, bool single) {
    const auto path = put(directory / "p.npy", npy_file(descr, "(1, 2)", number_bytes(numbers)));
    return message_of([&] {
      if (single) {
        read_points<float>(path);
      } else {
        read_points<double>(path);
      }
    });
  };
  const std::string good = "nothing thrown";
  CHECK(message(std::vector<std::int32_t>{1 << 24, -(1 << 24)}, "<i4", true) == good);
  CHECK(contains(message(std::vector<std::int32_t>{0, (1 << 24) + 1}, "<i4", true),
                 "row 0, column 1: 16777217 is a whole number that float32 does not hold exactly"));
  CHECK(contains(message(std::vector<std::int32_t>{0, 2147483647}, "<i4", true), "2147483647"));
  CHECK(message(std::vector<std::int32_t>{-2147483647 - 1, 2147483647}, "<i4", false) == good);
  CHECK(message(std::vector<std::int64_t>{1LL << 53, -(1LL << 62)}, "<i8", false) == good);
  CHECK(contains(message(std::vector<std::int64_t>{0, -(1LL << 53) - 1}, "<i8", false),
                 "-9007199254740993 is a whole number that float64 does not hold"));
  CHECK(message(std::vector<std::int64_t>{std::numeric_limits<std::int64_t>::min(), 0}, "<i8",
                true) == good);
  const auto most = std::numeric_limits<std::uint64_t>::max();
  CHECK(contains(message(std::vector<std::uint64_t>{most, 0}, "<u8", false),
                 "row 0, column 0: 18446744073709551615"));
}

TEST_CASE(".npy: indices of every integer type") {
  const TemporaryDirectory directory;
  const std::vector<Index> expected = {1, 2, 3, 4, 5, 6};
  const auto check = [&](const std::string& descr, const auto& numbers, bool big) {
    const auto path = put(directory / "i.npy", npy_file(descr, "(6,)", number_bytes(numbers, big)));
    CHECK(read_indices(path) == expected);
  };
  check("|u1", one_to_six<std::uint8_t>(), false);
  check("<i2", one_to_six<std::int16_t>(), false);
  check(">i4", one_to_six<std::int32_t>(), true);
  check("<u8", one_to_six<std::uint64_t>(), false);
  const std::vector<std::uint32_t> large = {7, 1U << 31U};
  put(directory / "i.npy", npy_file("<u4", "(2,)", number_bytes(large)));
  CHECK(contains(message_of([&] { read_indices(directory / "i.npy"); }),
                 "row 1: 2147483648 does not fit 32 bits"));
}

TEST_CASE(".npy: volumes of bool and float16, in Fortran order") {
  const TemporaryDirectory directory;
  const auto stored = [](const Volume& volume) {
    std::vector<double> values;
    std::visit(
        [&](const auto& span) {
          for (const auto value : span) values.push_back(static_cast<double>(value));
        },
        volume.stored());
    return values;
  };
  // Entry [a, b, c] is 100 a + 10 b + c.
  std::vector<std::int16_t> rows;
  std::vector<std::int16_t> columns;
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 3; ++b) {
      for (int c = 0; c < 2; ++c) rows.push_back(static_cast<std::int16_t>(100 * a + 10 * b + c));
    }
  }
  for (int c = 0; c < 2; ++c) {
    for (int b = 0; b < 3; ++b) {
      for (int a = 0; a < 4; ++a) {
        columns.push_back(static_cast<std::int16_t>(100 * a + 10 * b + c));
      }
    }
  }
  const VolumeLayout layout{.spacing = {1, 2, 3}, .origin = {7, 8, 9}};
  for (const bool fortran : {false, true}) {
    const auto path =
        put(directory / "v.npy",
            npy_file("<i2", "(4, 3, 2)", number_bytes(fortran ? columns : rows), fortran));
    const Volume volume = read_volume(path, layout);
    const auto values = stored(volume);
    // The place of every value in the world says which entry it must be.
    std::size_t i = 0;
    for (std::int64_t z = 0; z < volume.grid.shape[2]; ++z) {
      for (std::int64_t y = 0; y < volume.grid.shape[1]; ++y) {
        for (std::int64_t x = 0; x < volume.grid.shape[0]; ++x) {
          const Eigen::Vector3d cell(static_cast<double>(x), static_cast<double>(y),
                                     static_cast<double>(z));
          const Eigen::Vector3d at = volume.grid.origin.eigen() + volume.grid.axes.eigen() * cell;
          CHECK(values[i++] == 100 * (at[0] - 7) + 10 * (at[1] - 8) / 2 + (at[2] - 9) / 3);
        }
      }
    }
  }
  const std::vector<std::uint16_t> halves = {0x3C00, 0xC500, 0x7BFF, 0x0001, 0x0000, 0x3555};
  for (const bool big : {false, true}) {
    put(directory / "h.npy", npy_file(big ? ">f2" : "<f2", "(1, 2, 3)", number_bytes(halves, big)));
    const Volume volume = read_volume(directory / "h.npy");
    CHECK(volume.type == VoxelType::float32);
    CHECK(stored(volume) ==
          std::vector<double>{1, -5, 65504, std::ldexp(1.0, -24), 0, 1365.0 / 4096});
  }
  put(directory / "b.npy", npy_file("|b1", "(1, 2, 2)", std::string("\0\1\5\0", 4)));
  CHECK(read_volume(directory / "b.npy").type == VoxelType::uint8);
  CHECK(stored(read_volume(directory / "b.npy")) == std::vector<double>{0, 1, 1, 0});
  put(directory / "e.npy", npy_file("<f4", "(2, 0, 3)", ""));
  CHECK(contains(message_of([&] { read_volume(directory / "e.npy"); }),
                 "has the shape (2, 0, 3): no cells"));
  put(directory / "c.npy", npy_file("<c8", "(1, 1, 1)", "12345678"));
  CHECK(contains(message_of([&] { read_volume(directory / "c.npy"); }), "has dtype '<c8'"));
}

TEST_SUITE_END();

}  // namespace ccvt::test
