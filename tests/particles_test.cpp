#include "ccvt/particles.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "support/files.h"
#include "support/message.h"

namespace ccvt::test {
namespace {

template <class Value>
Value value_at(const std::string& bytes, std::size_t at) {
  Value value{};
  REQUIRE(at + sizeof value <= bytes.size());
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class Value>
std::vector<Value> values_of(const std::string& bytes) {
  REQUIRE(bytes.size() % sizeof(Value) == 0);
  std::vector<Value> values(bytes.size() / sizeof(Value));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

/// The records of a file of Fortran's.
std::vector<std::string> records_of(const std::string& bytes) {
  std::vector<std::string> records;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto length = value_at<std::uint32_t>(bytes, at);
    records.push_back(bytes.substr(at + 4, length));
    CHECK(value_at<std::uint32_t>(bytes, at + 4 + length) == length);
    at += 8 + length;
  }
  return records;
}

/// Where particle `number`, from 0, is, in long double.
std::array<long double, 3> place(const Points<double>& sites, const ParticleOptions& options,
                                 std::uint64_t number) {
  const auto n = static_cast<std::uint64_t>(sites.cols());
  const auto repeat = static_cast<std::uint64_t>(options.repeat);
  std::uint64_t tile = number / n;
  std::array<long double, 3> result{};
  for (std::size_t d = 0; d < 3; ++d, tile /= repeat) {
    const long double x =
        sites(static_cast<Eigen::Index>(d), static_cast<Eigen::Index>(number % n));
    result[d] = (x + static_cast<long double>(tile % repeat)) * options.box_size / options.repeat;
  }
  return result;
}

/// The largest distance along an axis, around the box, from where the particles should be.
template <class Real>
double worst_of(const std::vector<Real>& xyz, const Points<double>& sites,
                const ParticleOptions& options) {
  REQUIRE(xyz.size() == 3 * particle_count(static_cast<Index>(sites.cols()), options));
  long double worst = 0;
  for (std::size_t i = 0; i < xyz.size(); ++i) {
    const long double off =
        std::abs(place(sites, options, i / 3)[i % 3] - static_cast<long double>(xyz[i]));
    worst = std::max(worst, std::min(off, options.box_size - off));
    CHECK(static_cast<double>(xyz[i]) >= 0);
    CHECK(static_cast<double>(xyz[i]) < options.box_size);
  }
  return static_cast<double>(worst);
}

/// Sites at random, and at the faces.
Points<double> some_sites() {
  Points<double> sites = sample_uniform<double>(Box::unit(3), 40, 3, Distribution::white);
  sites.col(0).setZero();
  sites.col(1).setOnes();
  sites.col(2).setConstant(std::nextafter(1.0, 0.0));
  sites.col(3).setConstant(std::numeric_limits<double>::denorm_min());
  return sites;
}

template <class Scalar>
void check_gadget(int format, ParticleType type) {
  CAPTURE(format);
  CAPTURE(sizeof(Scalar));
  const TemporaryDirectory directory;
  // 0.1 rounds up to float32: a coordinate of that is outside the box.
  ParticleOptions options{.box_size = 0.1, .repeat = 3, .density = 7, .redshift = 49};
  options.type = type;
  options.gadget_format = format;
  const Points<Scalar> sites = some_sites().cast<Scalar>();
  const Points<double> same = sites.template cast<double>();
  write_particles(directory / "p.gadget", sites, options);
  CHECK(directory.entries() == 1);

  std::vector<std::string> records = records_of(get(directory / "p.gadget"));
  const bool gas = type == ParticleType::gas;
  const std::size_t blocks = gas ? 5 : 4;
  if (format == 2) {
    REQUIRE(records.size() == 2 * blocks);
    const char* const labels[] = {"HEAD", "POS ", "VEL ", "ID  ", "U   "};
    for (std::size_t b = 0; b < blocks; ++b) {
      REQUIRE(records[b].size() == 8);
      CHECK(records[b].substr(0, 4) == labels[b]);
      CHECK(value_at<std::uint32_t>(records[b], 4) == records[b + 1].size() + 8);
      records.erase(records.begin() + static_cast<std::ptrdiff_t>(b));
    }
  }
  REQUIRE(records.size() == blocks);
  const std::uint32_t count = 40 * 27;
  const std::string& header = records[0];
  CHECK(header.size() == 256);
  for (std::size_t t = 0; t < 6; ++t) {
    const bool here = t == (gas ? 0U : 1U);
    CHECK(value_at<std::uint32_t>(header, 4 * t) == (here ? count : 0));
    CHECK(value_at<std::uint32_t>(header, 96 + 4 * t) == (here ? count : 0));
    CHECK(value_at<std::uint32_t>(header, 168 + 4 * t) == 0);
    const auto mass = value_at<double>(header, 24 + 8 * t);
    CHECK(mass == doctest::Approx(here ? 7 * 0.1 * 0.1 * 0.1 / count : 0).epsilon(1e-14));
  }
  CHECK(value_at<double>(header, 72) == doctest::Approx(1.0 / 50));
  CHECK(value_at<double>(header, 80) == 49);
  CHECK(value_at<std::int32_t>(header, 124) == 1);
  CHECK(value_at<double>(header, 128) == 0.1);
  CHECK(value_at<std::int32_t>(header, 196) == (sizeof(Scalar) == 8 ? 1 : 0));

  const auto xyz = values_of<Scalar>(records[1]);
  CHECK(worst_of(xyz, same, options) <= 0.1 * std::numeric_limits<Scalar>::epsilon());
  CHECK(values_of<Scalar>(records[2]) == std::vector<Scalar>(3 * count));
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 1U);
  CHECK(values_of<std::uint32_t>(records[3]) == numbers);
  if (gas) CHECK(values_of<Scalar>(records[4]) == std::vector<Scalar>(count));

  // The reader finds the same, in either precision.
  const PointsHeader read = inspect_points(directory / "p.gadget");
  CHECK(read.dimension == 3);
  CHECK(read.count == count);
  CHECK((read.scalar == ScalarType::float64) == (sizeof(Scalar) == 8));
  CHECK(read.box == std::vector<double>(3, 0.1));
  const auto points = read_points<double>(directory / "p.gadget");
  REQUIRE(points.cols() == count);
  CHECK(std::equal(xyz.begin(), xyz.end(), points.data()));
  const auto narrow = read_points<float>(directory / "p.gadget", {.columns = {"3"}});
  CHECK(narrow.rows() == 1);
  CHECK(narrow(0, 77) == static_cast<float>(points(2, 77)));
}

}  // namespace

TEST_SUITE_BEGIN("particles");

TEST_CASE("particles: GADGET files hold the sites, tile by tile, inside the box") {
  for (const int format : {1, 2}) {
    check_gadget<float>(format, ParticleType::dark_matter);
    check_gadget<double>(format, ParticleType::dark_matter);
    check_gadget<float>(format, ParticleType::gas);
  }
}

TEST_CASE("particles: more than a block of them, whose borders are not those of tiles") {
  const TemporaryDirectory directory;
  const Points<double> sites =
      sample_uniform<double>(Box::unit(3), 1777, 3, Distribution::white, 1);
  const ParticleOptions options{.box_size = 64, .repeat = 4};
  write_particles(directory / "p.gadget", sites, options);
  const auto points = read_points<double>(directory / "p.gadget");
  REQUIRE(points.cols() == 1777 * 64);  // 1.7 blocks
  CHECK(worst_of(std::vector<double>(points.data(), points.data() + points.size()), sites,
                 options) < 1e-13);
}

TEST_CASE("particles: counts of 64 bits") {
  CHECK(particle_count(2147483647, {.repeat = 1000}) == 2147483647ULL * 1000000000ULL);
  CHECK(particle_count(262144, {.repeat = 26}) == 4607442944ULL);
  CHECK(particle_mass(8, {.box_size = 4, .repeat = 2, .density = 3}) == 3);
}

TEST_CASE("particles: bad input is told before anything is written") {
  const TemporaryDirectory directory;
  const Points<float> sites = Points<float>::Constant(3, 2, 0.5F);
  const auto told = [&](const char* name, const auto& points, const ParticleOptions& options) {
    return message_of([&] { write_particles(directory / name, points, options); });
  };
  const auto has = [](const std::string& text, const std::string& part) {
    CAPTURE(text);
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  };
  has(told("p.npy", sites, {}), "unknown extension '.npy'; particles go into .gadget or .hdf5");
  has(told("p.gadget", sites, {.box_size = 0}), "box_size: 0 is not from 1e-30 to 1e30");
  has(told("p.gadget", sites, {.box_size = NAN}), "box_size: nan");
  has(told("p.gadget", sites, {.repeat = 0}), "repeat: 0 is not from 1 to 1000");
  has(told("p.gadget", sites, {.repeat = 1001}), "repeat: 1001");
  has(told("p.gadget", sites, {.density = 0}), "density: 0 is not positive");
  has(told("p.gadget", sites, {.box_size = 1e-30, .density = 1e-300}), "masses are positive");
  has(told("p.gadget", sites, {.redshift = -1}), "redshift: -1 is not at least 0");
  has(told("p.gadget", sites, {.gadget_format = 3}), "gadget_format: 3 is not 1 or 2");
  has(told("p.gadget", Points<float>(3, 0), {}), "sites: there are none");
  has(told("p.gadget", Points<float>::Zero(2, 4).eval(), {}), "sites: have 2 dimensions");
  Points<float> outside = sites;
  outside(1, 1) = 1.5F;
  has(told("p.gadget", outside, {}), "coordinate 1 of site 1 is 1.5, outside the unit cube");
  outside(1, 1) = NAN;
  has(told("p.gadget", outside, {}), "coordinate 1 of site 1 is nan");
  has(told("p.gadget", sites, {.repeat = 448}),
      "179830784 particles are more than the 178956970 that a record of a GADGET file holds as "
      "float32; .hdf5 holds them");
  CHECK(message_of([&] { check_particles("p.gadget", 178956970, 4, {}); }) == "nothing thrown");
  CHECK(message_of([&] { check_particles("p.gadget", 178956971, 4, {}); }) != "nothing thrown");
  CHECK(directory.entries() == 0);
}

TEST_CASE("particles: cancelled, nothing is left; failed, nothing but what was there") {
  const TemporaryDirectory directory;
  put(directory / "p.gadget", "old");
  const Points<float> sites = Points<float>::Constant(3, 100, 0.5F);
  int calls = 0;
  ParticleOptions options{.repeat = 20};
  options.cancelled = [&calls] { return ++calls == 5; };
  CHECK_THROWS_AS(write_particles(directory / "p.gadget", sites, options), Cancelled);
  CHECK(directory.entries() == 1);
  CHECK(get(directory / "p.gadget") == "old");
  CHECK(message_of([&] {
          write_particles(directory / "none/p.gadget", sites);
        }).find("IoError: ") == 0);
}

TEST_CASE("particles: damaged GADGET files are refused") {
  const TemporaryDirectory directory;
  const Points<float> sites = Points<float>::Constant(3, 5, 0.5F);
  write_particles(directory / "one.gadget", sites);
  write_particles(directory / "two.gadget", sites, {.gadget_format = 2});
  const std::string one = get(directory / "one.gadget");
  const std::string two = get(directory / "two.gadget");
  const auto told = [&](const std::string& bytes) {
    put(directory / "bad.gadget", bytes);
    return message_of([&] { read_points<double>(directory / "bad.gadget"); });
  };
  const auto with = [](std::string bytes, std::size_t at, std::uint32_t value) {
    std::memcpy(&bytes.at(at), &value, sizeof value);
    return bytes;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
  };
  CHECK(told(one) == "nothing thrown");
  CHECK(told(two) == "nothing thrown");
  has(told("some text that is no such file"), "is no GADGET file");
  has(told(with(one, 0, 0x10000)), "big endian");
  has(told(with(one, 260, 255)), "256 bytes has 255 behind it");
  has(told(with(one, 8, 0)), "no particles");
  has(told(with(one, 8, 6)), "60 bytes; 6 particles take 12 or 24");
  has(told(with(one, 8, 0xF0000000U)), "at most 2147483647");
  has(told(with(one, 128, 4)), "one of 4 files");
  has(told(with(one, 268, 0x7FC00000U)), "not finite");
  has(told(with(two, 284, 0x20202020U)), "'POS '");
  // Steps that never end with a record.
  for (std::size_t size = 1; size < one.size(); size += 5) {
    CAPTURE(size);
    CHECK(told(one.substr(0, size)) != "nothing thrown");
    CHECK(told(two.substr(0, size)) != "nothing thrown");
  }
}

#ifdef CCVT_TEST_HDF5

TEST_CASE("particles: HDF5 files give the same positions, and the same bytes at any time") {
  const TemporaryDirectory directory;
  const ParticleOptions options{.box_size = 0.1, .repeat = 3};
  const Points<double> sites = some_sites();
  write_particles(directory / "p.gadget", sites, options);
  write_particles(directory / "p.hdf5", sites, options);
  const PointsHeader read = inspect_points(directory / "p.hdf5");
  CHECK(read.dimension == 3);
  CHECK(read.count == 40 * 27);
  CHECK(read.scalar == ScalarType::float64);
  CHECK(read.box == std::vector<double>(3, 0.1));
  CHECK(read_points<double>(directory / "p.hdf5") == read_points<double>(directory / "p.gadget"));
  CHECK(read_points<float>(directory / "p.hdf5") ==
        read_points<double>(directory / "p.hdf5").cast<float>());
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // times in the file have seconds
  write_particles(directory / "q.hdf5", sites, options);
  CHECK(get(directory / "p.hdf5") == get(directory / "q.hdf5"));

  // Velocities and masses are no more than their fill values.
  CHECK(get(directory / "p.hdf5").size() < 40 * 27 * 28 + 20000);
}

TEST_CASE("particles: HDF5, cancelled or failed") {
  const TemporaryDirectory directory;
  put(directory / "p.hdf5", "old");
  const Points<float> sites = Points<float>::Constant(3, 100, 0.5F);
  int calls = 0;
  ParticleOptions options{.repeat = 20};
  options.cancelled = [&calls] { return ++calls == 5; };
  CHECK_THROWS_AS(write_particles(directory / "p.hdf5", sites, options), Cancelled);
  CHECK(directory.entries() == 1);
  CHECK(get(directory / "p.hdf5") == "old");
  CHECK(message_of([&] { write_particles(directory / "none/p.hdf5", sites); }).find("IoError: ") ==
        0);
}

TEST_CASE("particles: damaged HDF5 files are refused") {
  const TemporaryDirectory directory;
  write_particles(directory / "p.hdf5", Points<float>::Constant(3, 500, 0.5F).eval());
  const std::string bytes = get(directory / "p.hdf5");
  put(directory / "text.hdf5", "some text that is no such file");
  CHECK(message_of([&] { read_points<double>(directory / "text.hdf5"); }).find("is no HDF5 file") !=
        std::string::npos);
  for (const std::size_t size : {bytes.size() / 8, bytes.size() / 2, bytes.size() - 100}) {
    put(directory / "cut.hdf5", bytes.substr(0, size));
    CHECK(message_of([&] { read_points<double>(directory / "cut.hdf5"); }) != "nothing thrown");
  }
}

#else

TEST_CASE("particles: without HDF5 the library says what is missing") {
  const TemporaryDirectory directory;
  const Points<float> sites = Points<float>::Constant(3, 5, 0.5F);
  put(directory / "p.hdf5", "x");
  for (const std::string& told :
       {message_of([&] { write_particles(directory / "p.hdf5", sites); }),
        message_of([&] { check_particles(directory / "p.hdf5", 5, 4, {}); }),
        message_of([&] { read_points<double>(directory / "p.hdf5"); })}) {
    CHECK(told.find("built without HDF5; with libhdf5-dev") != std::string::npos);
  }
}

#endif

TEST_SUITE_END();

}  // namespace ccvt::test
