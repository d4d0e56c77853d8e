#include "ccvt/io.h"

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "support/files.h"
#include "support/message.h"

using namespace std::string_literals;

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

/// An .npy file with any header text, so that it may lie.
std::string npy(const std::string& dictionary, const std::string& data, char major = 1) {
  std::string bytes = "\x93NUMPY"s + major + '\0';
  const auto length = static_cast<std::uint32_t>(dictionary.size());
  for (unsigned i = 0; i < (major == 1 ? 2U : 4U); ++i) {
    bytes += static_cast<char>((length >> (8 * i)) & 0xFFU);
  }
  return bytes + dictionary + data;
}

std::string header(const std::string& descr, const std::string& shape,
                   const std::string& fortran = "False") {
  return "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

template <class Scalar>
Points<Scalar> awkward_points() {
  using Limits = std::numeric_limits<Scalar>;
  Points<Scalar> points(3, 5);
  points << Scalar(0), Scalar(-0.0), Limits::max(), Limits::lowest(), Limits::min(),
      Limits::denorm_min(), Scalar(0.1), Scalar(1) / 3, Scalar(1e-7), Scalar(123456789),
      Limits::epsilon(), 1 + Limits::epsilon(), Scalar(-2.5), Scalar(1e30), Scalar(7);
  return points;
}

template <class Scalar>
bool same_bits(const Points<Scalar>& a, const Points<Scalar>& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(Scalar)) == 0;
}

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE_TEMPLATE("points come back bit for bit", Scalar, float, double) {
  const TemporaryDirectory directory;
  for (const char* const name : {"p.npy", "p.csv", "p.txt", "P.NPY", "p.CSV"}) {
    CAPTURE(name);
    const auto points = awkward_points<Scalar>();
    write_points(directory / name, points);
    CHECK(same_bits(read_points<Scalar>(directory / name), points));
    const PointsHeader found = inspect_points(directory / name);
    CHECK(found.dimension == 3);
    CHECK(found.count == 5);
  }
  CHECK(directory.entries() == 5);
}

TEST_CASE("a strided view is written like a matrix") {
  const TemporaryDirectory directory;
  Points<double> wide = Points<double>::Random(4, 6);
  const Points<double> part = wide.topRows(2);
  for (const char* const extension : {".npy", ".csv"}) {
    write_points(directory / ("strided"s + extension), wide.topRows(2));
    write_points(directory / ("packed"s + extension), part);
    CHECK(get(directory / ("strided"s + extension)) == get(directory / ("packed"s + extension)));
  }
}

TEST_CASE("the bytes of .npy are those of NumPy") {
  const TemporaryDirectory directory;
  Points<float> points(2, 3);
  points << 1, 3, 5, 2, 4, 6;
  write_points(directory / "p.npy", points);
  const std::string bytes = get(directory / "p.npy");
  REQUIRE(bytes.size() == 128 + 24);
  CHECK(bytes.substr(0, 10) == "\x93NUMPY\x01\x00\x76\x00"s);
  CHECK(bytes.substr(10, 60) == "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2), } "s);
  CHECK(bytes[127] == '\n');
  CHECK(bytes.substr(128) == bytes_of<float>({1, 2, 3, 4, 5, 6}));
  write_owners(directory / "o.npy", std::vector<Index>{7, 0, -1});
  const std::string owners = get(directory / "o.npy");
  CHECK(contains(owners, "{'descr': '<i4', 'fortran_order': False, 'shape': (3,), }"));
  CHECK(owners.substr(128) == bytes_of<std::int32_t>({7, 0, -1}));
}

TEST_CASE("all versions, quotes and key orders of .npy") {
  const TemporaryDirectory directory;
  const std::string data = bytes_of<double>({1, 2, 3, 4, 5, 6});
  const std::string dictionaries[] = {
      header("<f8", "(3, 2)"), header("<f8", "(3L, 2L)"),
      "{\"shape\":(3,2),\"fortran_order\":False,\"descr\":\"<f8\"}",
      "  { 'fortran_order' : False , 'shape' : ( 3 , 2 , ) , 'descr' : '<f8' }   \n"};
  for (const auto& dictionary : dictionaries) {
    for (const char major : {'\1', '\2', '\3'}) {
      CAPTURE(dictionary);
      const auto points =
          read_points<double>(put(directory / "p.npy", npy(dictionary, data, major)));
      REQUIRE(points.rows() == 2);
      REQUIRE(points.cols() == 3);
      CHECK(points(0, 0) == 1);
      CHECK(points(1, 0) == 2);
      CHECK(points(1, 2) == 6);
    }
  }
}

TEST_CASE("float64 is rounded to float, float32 widened") {
  const TemporaryDirectory directory;
  const Points<double> wide = 1e3 * Points<double>::Random(3, 50000);
  write_points(directory / "wide.npy", wide);
  const Points<float> rounded = wide.cast<float>();
  CHECK(same_bits(read_points<float>(directory / "wide.npy"), rounded));
  write_points(directory / "narrow.npy", rounded);
  const Points<double> widened = rounded.cast<double>();
  CHECK(same_bits(read_points<double>(directory / "narrow.npy"), widened));
  CHECK(inspect_points(directory / "wide.npy").scalar == ScalarType::float64);
  CHECK(inspect_points(directory / "narrow.npy").scalar == ScalarType::float32);
}

TEST_CASE("text in all its forms") {
  const TemporaryDirectory directory;
  const char* const texts[] = {
      "1,2\n3,4\n",
      "1,2\n3,4",
      "1;2\r\n3;4\r\n",
      "1 2\n3\t4\n",
      "  1   2  \n\n\n 3 4 # the end\n# more",
      "# a comment\nx,y\n1 , 2\n3 ,4\n",
      "\xEF\xBB\xBFlongitude in degrees, latitude\n+1,2.0\n0.3e1,4\n",
  };
  for (const char* const text : texts) {
    CAPTURE(text);
    const auto points = read_points<double>(put(directory / "p.csv", text));
    REQUIRE(points.rows() == 2);
    REQUIRE(points.cols() == 2);
    CHECK(points(0, 0) == 1);
    CHECK(points(1, 0) == 2);
    CHECK(points(0, 1) == 3);
    CHECK(points(1, 1) == 4);
    CHECK(inspect_points(directory / "p.csv").count >= 2);
    CHECK(inspect_points(directory / "p.csv").dimension == 2);
  }
}

TEST_CASE("text that spans many blocks") {
  const TemporaryDirectory directory;
  const Points<double> points = Points<double>::Random(7, 40000);
  write_points(directory / "p.csv", points);
  REQUIRE(fs::file_size(directory / "p.csv") > (4U << 20U));
  CHECK(same_bits(read_points<double>(directory / "p.csv"), points));
  CHECK(inspect_points(directory / "p.csv").count == 40000);
  const Points<float> one = Points<float>::Random(300000, 1);
  write_points(directory / "one.txt", one);
  CHECK(same_bits(read_points<float>(directory / "one.txt"), one));
}

TEST_CASE("values too small for float are zero, values too large are refused") {
  const TemporaryDirectory directory;
  CHECK(read_points<float>(put(directory / "p.csv", "1e-60,-1e-60\n")).isZero(0));
  const std::string zeros(400, '0');
  const std::string many(20000, '0');
  put(directory / "p.csv", "1e-400,-1e-400,1e-99999," + ("." + zeros) + "1,0." + many + "1,-0." +
                               many + "1e5,123." + zeros + "e-500,1e-9999999999999999999999\n");
  CHECK(read_points<float>(directory / "p.csv").isZero(0));
  CHECK(read_points<double>(directory / "p.csv").isZero(0));
  for (const std::string& junk : {"1e-400x"s, "1e400x"s, "1" + zeros + "e", "1e-99999e-1"s}) {
    CAPTURE(junk);
    const std::string message =
        message_of([&] { read_points<double>(put(directory / "p.csv", "1,2\n3," + junk + "\n")); });
    CHECK(contains(message, "line 2: field 2: "));
    CHECK(contains(message, "is not a number"));
  }
  for (const std::string& large : {"1e400"s, "-1e400"s, "1e99999"s, "1" + many + "e-5",
                                   "0." + many + "1e20500", "1e9999999999999999999999"s}) {
    CHECK(contains(message_of([&] { read_points<double>(put(directory / "p.csv", large)); }),
                   "is out of the range of float64"));
  }
  CHECK(contains(message_of([&] { read_points<float>(put(directory / "p.csv", "1,1e60\n")); }),
                 "line 1: field 2: '1e60' is out of the range of float32"));
  put(directory / "p.npy", npy(header("<f8", "(2, 1)"), bytes_of<double>({1, 1e60})));
  CHECK(contains(message_of([&] { read_points<float>(directory / "p.npy"); }),
                 "row 1, column 0: 1e+60 is out of the range of float32"));
}

TEST_CASE("lines end with line feeds") {
  const TemporaryDirectory directory;
  Points<double> expected(2, 2);
  expected << 1, 3, 2, 4;
  CHECK(read_points<double>(put(directory / "p.txt", "1 2\r\n3 4\r\n")) == expected);
  CHECK(read_points<double>(put(directory / "p.txt", "1,2\r\r\n\"3\",4\r")) == expected);
  for (const char* const text : {"1 2\r3 4\r", "x,y\r1,2\r3,4", "# two\r1 2\r3 4\r\n"}) {
    CHECK(contains(message_of([&] { read_points<double>(put(directory / "p.txt", text)); }),
                   "line 1: has a carriage return inside; end lines with line feeds"));
  }
}

TEST_CASE("NumPy data in a text file is told") {
  const TemporaryDirectory directory;
  put(directory / "p.txt", npy(header("<f8", "(2, 1)"), bytes_of<double>({1, 2})));
  CHECK(contains(message_of([&] { read_points<double>(directory / "p.txt"); }),
                 "p.txt: line 1: is NumPy data, not text: a file is to end in .npy, and standard "
                 "input is npy:-"));
}

TEST_CASE("hostile files are refused with one line that names them") {
  const TemporaryDirectory directory;
  const std::string six = bytes_of<double>({1, 2, 3, 4, 5, 6});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  struct Case {
    std::string name;
    std::string bytes;
    std::string expected;
  };
  const Case cases[] = {
      {"empty.npy", "", "is empty"},
      {"magic.npy", "PK\x03\x04 not an array", "is not an .npy file"},
      {"short.npy", "\x93NUM", "is not an .npy file"},
      {"version.npy", npy(header("<f8", "(3, 2)"), six, 9), "version 9.0"},
      {"length.npy", "\x93NUMPY\x02\x00\xFF\xFF\xFF\xFF{"s, "claims 4294967295 bytes"},
      {"cut-header.npy", npy(header("<f8", "(3, 2)"), "").substr(0, 40), "is truncated"},
      {"truncated.npy", npy(header("<f8", "(3, 2)"), six.substr(0, 47)),
       "needs 48 bytes of data, there are 47"},
      {"long.npy", npy(header("<f8", "(3, 2)"), six + "x"), "is too long"},
      {"huge.npy", npy(header("<f8", "(1000000000000, 2)"), six), "is truncated"},
      {"overflow.npy", npy(header("<f8", "(4294967296, 4294967296)"), six), "no file can hold"},
      {"wraps.npy", npy(header("<f8", "(2305843009213693952, 8)"), ""), "no file can hold"},
      {"beyond.npy", npy(header("<f8", "(99999999999999999999, 2)"), six), "beyond 64 bits"},
      {"negative.npy", npy(header("<f8", "(-3, -2)"), six), "negative"},
      {"no-points.npy", npy(header("<f8", "(0, 2)"), ""), "no points"},
      {"no-dimensions.npy", npy(header("<f8", "(3, 0)"), ""), "no dimensions"},
      {"vector.npy", npy(header("<f8", "(6,)"), six), "(6,)"},
      {"cube.npy", npy(header("<f8", "(1, 2, 3)"), six), "(1, 2, 3)"},
      {"scalar.npy", npy(header("<f8", "()"), six), "()"},
      {"complex.npy", npy(header("<c8", "(3, 2)"), six), "'<c8'"},
      {"long-float.npy", npy(header("<f16", "(3, 1)"), six), "'<f16'"},
      {"order.npy", npy(header("<f8", "(3, 2)", "Perhaps"), six), "malformed"},
      {"cut-bytes.npy", npy(header("|u1", "(8, 7)"), six), "is truncated"},
      {"cut-column.npy", npy(header("<f8", "(3, 3)", "True"), six), "is truncated"},
      {"records.npy", npy("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (6,)}", six),
       "records"},
      {"no-shape.npy", npy("{'descr': '<f8', 'fortran_order': False}", six), "malformed"},
      {"twice.npy",
       npy("{'descr': '<f8', 'descr': '<f8', 'fortran_order': False, 'shape': (3, 2)}", six),
       "malformed"},
      {"open.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2", six),
       "malformed"},
      {"string.npy", npy("{'descr': '<f8", six), "malformed"},
      {"text.npy", npy("", six), "malformed"},
      {"nan.npy", npy(header("<f8", "(3, 2)"), bytes_of<double>({1, 2, 3, nan, 5, 6})),
       "row 1, column 1: nan is not finite"},
      {"inf.npy", npy(header("<f8", "(3, 2)"), bytes_of<double>({1, 2, 3, 4, -infinity, 6})),
       "row 2, column 0: -inf is not finite"},
      {"empty.csv", "", "is empty"},
      {"comments.csv", "# nothing\n\n  \n", "has no points"},
      {"header.csv", "x,y\n", "has no points"},
      {"word.csv", "1,2\n3,abc\n", "line 2: field 2: 'abc' is not a number"},
      {"headers.csv", "x,y\nlon,lat\n1,2\n", "line 2: field 1: 'lon' is not a number"},
      {"partly.csv", "x,1\n2,3\n", "line 1: field 1: 'x' is not a number"},
      {"suffix.csv", "1,2\n3,4m\n", "line 2: field 2: '4m' is not a number"},
      {"hex.csv", "1,2\n3,0x10\n", "'0x10' is not a number"},
      {"signs.csv", "1,2\n3,+-4\n", "'+-4' is not a number"},
      {"nan.csv", "# c\n1,2\nnan,2\n", "line 3: field 1: 'nan' is not finite"},
      {"inf.csv", "1,2\n1,-inf\n", "line 2: field 2: '-inf' is not finite"},
      {"range.csv", "1e999,2\n", "'1e999' is out of the range of float64"},
      {"ragged.csv", "1,2\n\n3,4,5\n", "line 3: has 3 coordinates, but line 1 has 2"},
      {"fewer.txt", "1 2\n3\n", "line 2: has 1 coordinates, but line 1 has 2"},
      {"hole.csv", "1,2,9\n3,,4\n", "line 2: field 2 is empty"},
      {"hole-at-end.csv", "1,2\n3,\n", "line 2: field 2 is empty"},
      {"tail.csv", "1,2,\n", "line 1: field 3 is empty"},
      {"mixed.csv", "1,5;2,5\n", "line 1: fields are separated in two ways"},
      {"decimal-comma.txt", "1,5 2,5\n", "line 1: fields are separated in two ways"},
      {"binary.csv", "1,\0\x01\xff\n"s, "line 1: field 2: '\?\?\?' is not a number"},
      {"endless.csv", std::string(200000, 'a') + ",1\n", "aaaa...' is not a number"},
      {"points.dat", "1 2\n", "unknown extension '.dat'"},
      {"points", "1 2\n", "unknown extension ''"},
  };
  for (const Case& c : cases) {
    const fs::path path = put(directory / c.name, c.bytes);
    const std::string message = message_of([&] { read_points<double>(path); });
    CAPTURE(c.name);
    CAPTURE(message);
    CHECK(contains(message, c.expected));
    CHECK(message.rfind(path.string() + ": ", 0) == 0);
    CHECK(message.find('\n') == std::string::npos);
    CHECK(message.size() < path.string().size() + 200);
    CHECK(message_of([&] { read_points<float>(path); }) != "nothing thrown");
  }
}

TEST_CASE("what is no file is refused") {
  const TemporaryDirectory directory;
  fs::create_directory(directory / "d.csv");
  CHECK(contains(message_of([&] { read_points<float>(directory / "none.csv"); }), "no such file"));
  CHECK(contains(message_of([&] { read_points<float>(directory / "d.csv"); }), "is a directory"));
  fs::create_symlink("/dev/zero", directory / "zero.csv");
  CHECK(contains(message_of([&] { read_points<float>(directory / "zero.csv"); }),
                 "is not a regular file"));
  CHECK(contains(message_of([&] { read_image(directory / "none.png"); }), "no such file"));
}

TEST_CASE("any byte of a good .npy header may be wrong") {
  const TemporaryDirectory directory;
  const std::string good = npy(header("<f8", "(3, 2)"), bytes_of<double>({1, 2, 3, 4, 5, 6}));
  const std::size_t data = good.size() - 48;
  int refused = 0;
  for (std::size_t at = 0; at < data; ++at) {
    for (const char c : {'\0', '(', '\'', '9', '\xff'}) {
      std::string bad = good;
      bad[at] = c;
      try {
        const auto points = read_points<double>(put(directory / "p.npy", bad));
        CHECK(points.size() == 6);  // the file holds six numbers, so no shape may say otherwise
      } catch (const InvalidInput&) {
        ++refused;
      }
    }
  }
  CHECK(refused > 200);
}

TEST_CASE("points that are not finite are not written") {
  const TemporaryDirectory directory;
  Points<float> points = Points<float>::Zero(2, 3);
  points(1, 2) = -INFINITY;
  for (const char* const name : {"p.npy", "p.csv", "p.txt"}) {
    put(directory / name, "old");
    CHECK(message_of([&] { write_points(directory / name, points); }) ==
          "points: coordinate 1 of points[2] is -inf: it must be finite");
    CHECK(get(directory / name) == "old");
  }
}

TEST_CASE("indices") {
  const TemporaryDirectory directory;
  const std::vector<Index> values = {5, 0, -1, std::numeric_limits<Index>::max()};
  for (const char* const name : {"i.npy", "i.csv", "i.txt"}) {
    write_owners(directory / name, values);
    CHECK(read_indices(directory / name) == values);
  }
  put(directory / "wide.npy", npy(header("<i8", "(2,)"), bytes_of<std::int64_t>({3, 1000000})));
  CHECK(read_indices(directory / "wide.npy") == std::vector<Index>{3, 1000000});
  // As numpy.savetxt() and divisions have them.
  const std::vector<Index> whole = {100, -3, 0, 2147483647};
  put(directory / "exponents.txt", "1.000000000000000000e+02\n-3.0\n0e0\n2147483647.0\n");
  CHECK(read_indices(directory / "exponents.txt") == whole);
  put(directory / "reals.npy",
      npy(header("<f8", "(4, 1)"), bytes_of<double>({100, -3, 0, 2147483647})));
  CHECK(read_indices(directory / "reals.npy") == whole);
  CHECK(contains(message_of([&] { read_indices(put(directory / "p.ply", "3\n")); }),
                 "p.ply: unknown extension '.ply'; whole numbers come from .npy, .csv or .txt"));

  struct Case {
    std::string name;
    std::string bytes;
    std::string expected;
  };
  const Case cases[] = {
      {"wide.npy", npy(header("<i8", "(2,)"), bytes_of<std::int64_t>({3, 1LL << 40})),
       "row 1: 1099511627776 does not fit 32 bits"},
      {"bools.npy", npy(header("|b1", "(1,)"), "\1"), "has dtype '|b1'; whole numbers are"},
      {"floats.npy", npy(header("<f8", "(3,)"), bytes_of<double>({3, 4, 2.5})),
       "row 2: 2.5 is not a whole number"},
      {"nan.npy", npy(header("<f4", "(1,)"), bytes_of<float>({NAN})),
       "row 0: nan is not a whole number"},
      {"inf.npy", npy(header("<f4", "(1,)"), bytes_of<float>({INFINITY})),
       "row 0: inf does not fit 32 bits"},
      {"wide_floats.npy", npy(header("<f8", "(2,)"), bytes_of<double>({-0x1p31, 0x1p31})),
       "row 1: 2147483648 does not fit 32 bits"},
      {"matrix.npy", npy(header("<i4", "(1, 2)"), bytes_of<std::int32_t>({3, 4})), "a vector"},
      {"none.npy", npy(header("<i4", "(0,)"), ""), "has no numbers"},
      {"cut.npy", npy(header("<i4", "(2,)"), bytes_of<std::int32_t>({3})), "is truncated"},
      {"half.csv", "3\n1.5\n", "line 2: '1.5' is not a whole number"},
      {"large.csv", "3\n2147483648\n", "line 2: '2147483648' does not fit 32 bits"},
      {"large.csv", "3\n1e12\n", "line 2: '1e12' does not fit 32 bits"},
      {"vast.csv", "3\n1e999\n", "line 2: '1e999' does not fit 32 bits"},
      {"tiny.csv", "3\n1e-999\n", "line 2: '1e-999' is not a whole number"},
      {"half.csv", "3\n15e-1\n", "line 2: '15e-1' is not a whole number"},
      {"word.csv", "3\nfour\n", "line 2: 'four' is not a whole number"},
      {"nan.csv", "3\nnan\n", "line 2: 'nan' is not a whole number"},
      {"pair.csv", "3\n1,5\n", "line 2: has 2 fields"},
      {"none.csv", "# none\n", "has no numbers"},
  };
  for (const Case& c : cases) {
    const std::string message = message_of([&] { read_indices(put(directory / c.name, c.bytes)); });
    CAPTURE(message);
    CHECK(contains(message, c.expected));
    CHECK(contains(message, (directory / c.name).string()));
  }
}

TEST_CASE("failed writes leave nothing behind and the old file in place") {
  const TemporaryDirectory directory;
  const Points<double> points = Points<double>::Random(2, 100000);
  const fs::path target = put(directory / "p.npy", "old");

  // The file size limit makes writes fail half way, as a full disk does.
  struct rlimit before = {};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit small = before;
  small.rlim_cur = 100000;
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  const std::string npy_message = message_of([&] { write_points(target, points); });
  const std::string csv_message = message_of([&] { write_points(directory / "p.csv", points); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  CHECK(npy_message.rfind("IoError: " + target.string() + ": cannot be written: ", 0) == 0);
  CHECK(csv_message.rfind("IoError: ", 0) == 0);
  CHECK(get(target) == "old");
  CHECK(directory.entries() == 1);

  CHECK(contains(message_of([&] { write_points(directory / "none/p.npy", points); }), "IoError: "));
  CHECK(contains(message_of([&] { write_points(directory / "p.dat", points); }), "extension"));
  fs::create_directory(directory / "d.npy");
  CHECK(contains(message_of([&] { write_points(directory / "d.npy", points); }), "IoError: "));
  CHECK(directory.entries() == 2);
}

TEST_SUITE_END();

}  // namespace ccvt::test
