#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "ccvt/volume.h"
#include "io/npy.h"
#include "random.h"
#include "support/files.h"
#include "support/volumes.h"

using ccvt::InvalidInput;
using ccvt::read_volume;
using ccvt::Volume;
using ccvt::VolumeLayout;
using ccvt::VoxelType;
using namespace ccvt::test;

namespace {

std::string refusal(const std::filesystem::path& path, const VolumeLayout& layout = {}) {
  try {
    read_volume(path, layout);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

template <class Value>
std::vector<Value> stored(const Volume& volume) {
  const auto values = std::get<std::span<const Value>>(volume.stored());
  return {values.begin(), values.end()};
}

const std::vector<std::uint8_t> kBytes = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,
                                          13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24};

std::string small_nifti() { return nifti1({2, 3, 4}, 2, 8) + bytes_of_values(kBytes); }

const std::string kNrrd =
    "NRRD0004\n# a comment\ntype: unsigned char\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n"
    "space: left-posterior-superior\nspace directions: (0,2,0) (1, 0,0) (0,0,-3)\n"
    "space origin: (5,6,7)\nkinds: domain domain domain\nname:=a value: with colons\na:b:=c\na: "
    "b:=c\ntype:=x\n";

template <class Value>
void check_nifti_type(int datatype, VoxelType type) {
  const TemporaryDirectory directory;
  const std::vector<Value> values = {static_cast<Value>(1), static_cast<Value>(-3),
                                     std::numeric_limits<Value>::max(),
                                     std::numeric_limits<Value>::lowest()};
  for (const bool swapped : {false, true}) {
    for (const bool second : {false, true}) {
      const int bits = 8 * static_cast<int>(sizeof(Value));
      const std::string header = second ? nifti2({4, 1, 1}, datatype, bits, swapped)
                                        : nifti1({4, 1, 1}, datatype, bits, swapped);
      const std::string bytes = header + bytes_of_values(values, swapped);
      for (const bool packed : {false, true}) {
        const auto path =
            put(directory / (packed ? "v.nii.gz" : "v.nii"), packed ? gzipped(bytes) : bytes);
        const Volume volume = read_volume(path);
        CHECK(volume.type == type);
        CHECK(volume.grid.shape == std::vector<std::int64_t>{4, 1, 1});
        CHECK(volume.grid.spacing() == Eigen::Vector3d(1, 2, 3));
        CHECK(stored<Value>(volume) == values);
      }
    }
  }
}

}  // namespace

TEST_SUITE_BEGIN("volume_io");

TEST_CASE("NIfTI: all types, both versions, both byte orders, packed or not") {
  check_nifti_type<std::uint8_t>(2, VoxelType::uint8);
  check_nifti_type<std::int16_t>(4, VoxelType::int16);
  check_nifti_type<std::int32_t>(8, VoxelType::int32);
  check_nifti_type<float>(16, VoxelType::float32);
  check_nifti_type<double>(64, VoxelType::float64);
  check_nifti_type<std::int8_t>(256, VoxelType::int8);
  check_nifti_type<std::uint16_t>(512, VoxelType::uint16);
  check_nifti_type<std::uint32_t>(768, VoxelType::uint32);
  check_nifti_type<std::int64_t>(1024, VoxelType::int64);
  check_nifti_type<std::uint64_t>(1280, VoxelType::uint64);
}

TEST_CASE("NIfTI: world coordinates by sform, else qform, else pixdim; slope and intercept") {
  const TemporaryDirectory directory;
  std::string bytes = small_nifti();
  const auto read = [&] { return read_volume(put(directory / "v.nii", bytes)); };
  CHECK(read().grid.axes == Eigen::Matrix3d(Eigen::Vector3d(1, 2, 3).asDiagonal()));
  CHECK(read().grid.origin.eigen() == Eigen::Vector3d::Zero());

  // A quarter turn about z, left-handed: i goes along y, j along -x, k along -z.
  put_at(bytes, 252, std::int16_t{1});
  put_at(bytes, 76, -1.0F);
  put_at(bytes, 264, std::sqrt(0.5F));
  put_at(bytes, 268, 10.0F);
  put_at(bytes, 276, -30.0F);
  Eigen::Matrix3d turned;
  turned << 0, -2, 0, 1, 0, 0, 0, 0, -3;
  CHECK((read().grid.axes.eigen() - turned).norm() < 1e-6);
  CHECK(read().grid.origin.eigen() == Eigen::Vector3d(10, 0, -30));

  put_at(bytes, 254, std::int16_t{2});
  const float rows[12] = {0, 2, 0, 5, 3, 0, 0.5F, 6, 0, 0, 4, 7};
  for (std::size_t i = 0; i < 12; ++i) put_at(bytes, 280 + 4 * i, rows[i]);
  Eigen::Matrix3d sheared;
  sheared << 0, 2, 0, 3, 0, 0.5, 0, 0, 4;
  CHECK(read().grid.axes == sheared);
  CHECK(read().grid.origin.eigen() == Eigen::Vector3d(5, 6, 7));

  CHECK(read().slope == 1);
  put_at(bytes, 112, 0.5F);
  put_at(bytes, 116, -2.0F);
  CHECK(read().slope == 0.5);
  CHECK(read().intercept == -2);
  CHECK(read().greatest() == 10);
}

TEST_CASE("NRRD: attached and detached, raw and packed") {
  const TemporaryDirectory directory;
  const std::string data = bytes_of_values(kBytes);
  std::string packed = kNrrd;
  packed.replace(packed.find("raw"), 3, "gzip");
  Eigen::Matrix3d axes;
  axes << 0, 1, 0, 2, 0, 0, 0, 0, -3;
  const auto check = [&](const std::filesystem::path& path) {
    const Volume volume = read_volume(path);
    CHECK(volume.grid.shape == std::vector<std::int64_t>{2, 3, 4});
    CHECK(volume.grid.axes == axes);
    CHECK(volume.grid.origin.eigen() == Eigen::Vector3d(5, 6, 7));
    CHECK(stored<std::uint8_t>(volume) == kBytes);
  };
  check(put(directory / "a.nrrd", kNrrd + "\n" + data));
  check(put(directory / "b.nrrd", packed + "\n" + gzipped(data)));
  put(directory / "c.data", data);
  put(directory / "d.data", gzipped("front" + data));
  check(put(directory / "c.nhdr", kNrrd + "data file: c.data\n"));
  check(put(directory / "c2.nhdr", kNrrd + "byte skip: -1\ndatafile: c.data\n\n"));
  check(put(directory / "d.nhdr", packed + "byteskip: 5\ndata file: d.data\n"));

  // Windows line ends, spacings, big endian.
  const auto path = put(directory / "e.nrrd",
                        "NRRD0001\r\nType: short\r\nDimension: 3\r\nsizes: 2 1 1\r\n"
                        "spacings: 0.5 1 2\r\nencoding: raw\r\nendian: big\r\n\r\n" +
                            bytes_of_values(std::vector<std::int16_t>{-2, 500}, true));
  CHECK(stored<std::int16_t>(read_volume(path)) == std::vector<std::int16_t>{-2, 500});
  CHECK(read_volume(path).grid.spacing() == Eigen::Vector3d(0.5, 1, 2));
}

TEST_CASE(".npy and raw: axes, spacing, origin, byte order") {
  const TemporaryDirectory directory;
  const auto npy = put(directory / "v.npy",
                       ccvt::io::format_npy_header("|u1", {4, 3, 2}) + bytes_of_values(kBytes));
  const Volume array = read_volume(npy, {.spacing = {1, 2, 3}, .origin = {7, 8, 9}});
  CHECK(array.grid.shape == std::vector<std::int64_t>{2, 3, 4});
  // Entry [3, 2, 1] of the array is the last one in memory.
  const Eigen::Vector3d last =
      array.grid.origin.eigen() + array.grid.axes.eigen() * Eigen::Vector3d(1, 2, 3);
  CHECK(last == Eigen::Vector3d(7 + 3 * 1, 8 + 2 * 2, 9 + 1 * 3));

  const std::vector<std::uint16_t> values = {1, 256, 4660, 7, 8, 9};
  const VolumeLayout layout{
      .shape = {3, 2, 1}, .type = VoxelType::uint16, .big_endian = true, .spacing = {1, 1, 3}};
  const auto raw = put(directory / "v.raw", bytes_of_values(values, true));
  CHECK(stored<std::uint16_t>(read_volume(raw, layout)) == values);
  CHECK(read_volume(raw, layout).grid.spacing() == Eigen::Vector3d(1, 1, 3));
  CHECK(mentions(refusal(raw), "needs a shape"));
  VolumeLayout longer = layout;
  longer.shape[2] = 2;
  CHECK(mentions(refusal(raw, longer),
                 "is truncated: 24 bytes of values are promised, but it has 12"));
  longer.shape[2] = -1;
  CHECK(mentions(refusal(raw, longer), "-1 cells along axis 2"));
  VolumeLayout shorter = layout;
  shorter.shape[0] = 2;
  CHECK(mentions(refusal(raw, shorter), "is too long: there are 4 bytes behind its data"));
  CHECK(mentions(refusal(npy, layout), "says its shape and type itself"));
  CHECK(mentions(refusal(put(directory / "v.nii", small_nifti()), {.origin = {1, 2, 3}}),
                 "says its spacing and origin itself"));
  CHECK(mentions(refusal(put(directory / "v.tif", "x")), "unknown extension '.tif'"));
  CHECK(mentions(refusal(put(directory / "v.gz", "x")), "unknown extension '.gz'"));
}

TEST_CASE("NIfTI: what cannot be read is refused by name") {
  const TemporaryDirectory directory;
  const std::string good = small_nifti();
  const auto message = [&](std::size_t offset, auto value) {
    std::string bytes = good;
    put_at(bytes, offset, value);
    return refusal(put(directory / "v.nii", bytes));
  };
  const auto i16 = [](int v) { return static_cast<std::int16_t>(v); };
  CHECK(message(148, 'x').empty());  // a description
  CHECK(mentions(message(0, std::int32_t{349}), "is not a NIfTI file"));
  CHECK(mentions(message(344, 'x'), "its magic is"));
  CHECK(mentions(message(345, 'i'), "pair of files"));
  CHECK(mentions(message(40, i16(0)), "0 dimensions"));
  CHECK(mentions(message(40, i16(8)), "8 dimensions"));
  CHECK(mentions(message(40, i16(2)), "a volume needs 3"));
  CHECK(mentions(message(42, i16(-2)), "dim[1] = -2"));
  CHECK(mentions(message(44, i16(0)), "dim[2] = 0"));
  CHECK(mentions(message(42, i16(32767)), "is truncated: 393204 bytes"));
  CHECK(mentions(message(70, i16(128)), "colours (RGB)"));
  CHECK(mentions(message(70, i16(32)), "complex"));
  CHECK(mentions(message(70, i16(1536)), "data type 1536"));
  CHECK(mentions(message(72, i16(16)), "of 16 bits (bitpix)"));
  CHECK(mentions(message(80, -1.0F), "pixdim[1] = -1"));
  CHECK(mentions(message(84, std::nanf("")), "pixdim[2] = nan"));
  CHECK(mentions(message(108, 0.0F), "vox_offset"));
  CHECK(mentions(message(108, -352.0F), "vox_offset"));
  CHECK(mentions(message(108, 352.5F), "vox_offset"));
  CHECK(mentions(message(108, HUGE_VALF), "vox_offset"));
  CHECK(mentions(message(108, 1e9F), "is truncated"));
  CHECK(mentions(message(112, HUGE_VALF), "scales its values"));
  CHECK(mentions(message(254, i16(1)), "or flat"));  // an sform of zeros
  std::string series = good;
  put_at(series, 40, i16(4));
  put_at(series, 48, i16(10));
  CHECK(mentions(refusal(put(directory / "v.nii", series)), "series of 10 volumes (4D)"));
  std::string rotated = good;
  put_at(rotated, 252, i16(1));
  put_at(rotated, 256, 7.0F);
  CHECK(mentions(refusal(put(directory / "v.nii", rotated)), "no rotation"));
  CHECK(mentions(refusal(put(directory / "v.nii", good + "x")), "too long"));
  CHECK(mentions(refusal(put(directory / "v.nii.gz", good)), "gzip data are invalid"));
  const std::string padded = gzipped(good) + std::string(100000, '\0');
  CHECK(read_volume(put(directory / "v.nii.gz", padded)).grid.shape.size() == 3);
  CHECK(mentions(refusal(put(directory / "v.nii.gz", padded + "xx")), "gzip data are invalid"));
  std::string damaged = gzipped(good);
  damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);  // checksum
  CHECK(mentions(refusal(put(directory / "v.nii.gz", damaged)), "damaged"));

  // 2^31 * 2^31 * 2^31 voxels, and as many as fit into 63 bits, but into no file.
  for (const std::int64_t extent : {std::int64_t{1} << 31, std::int64_t{1} << 20}) {
    std::string huge = nifti2({2, 3, 4}, 2, 8) + bytes_of_values(kBytes);
    for (std::size_t d = 0; d < 3; ++d) put_at(huge, 24 + 8 * d, extent);
    const std::string plain = refusal(put(directory / "v.nii", huge));
    const std::string packed = refusal(put(directory / "v.nii.gz", gzipped(huge)));
    CHECK(mentions(plain, extent == 1 << 20 ? "is truncated" : "more cells than any file"));
    CHECK(mentions(packed, extent == 1 << 20 ? "cannot hold more" : "more cells than any file"));
  }
}

TEST_CASE("NRRD: what cannot be read is refused by name") {
  const TemporaryDirectory directory;
  const std::string data = bytes_of_values(kBytes);
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string header = kNrrd;
    header.replace(header.find(from), from.size(), to);
    return refusal(put(directory / "v.nrrd", header + "\n" + data));
  };
  CHECK(message("a comment", "another").empty());
  CHECK(mentions(message("NRRD0004", "NRRD0009"), "is not an NRRD file"));
  CHECK(mentions(message("dimension: 3", "dimension: 4"), "has 4 dimensions"));
  CHECK(mentions(message("dimension: 3", "dimension: three"), "not a whole number"));
  CHECK(mentions(message("dimension: 3\n", ""), "has no field 'dimension'"));
  CHECK(mentions(message("sizes: 2 3 4", "sizes: 2 3"), "has 2 entries"));
  CHECK(mentions(message("sizes: 2 3 4", "sizes: 2 -3 4"), "-3 cells along axis 1"));
  CHECK(mentions(message("sizes: 2 3 4", "sizes: 2 3 5"), "is truncated: 30 bytes"));
  CHECK(mentions(message("sizes: 2 3 4", "sizes: 2 3 3"), "is too long"));
  CHECK(mentions(message("sizes: 2 3 4", "sizes: 99999999999999999999 3 4"), "64 bits"));
  CHECK(mentions(message("sizes: 2 3 4", "sizes: 9999999999 9999999999 4"), "any file"));
  CHECK(mentions(message("unsigned char", "block"), "type 'block'"));
  CHECK(mentions(message("unsigned char", "short"), "has no field 'endian'"));
  CHECK(mentions(message("encoding: raw", "encoding: bzip2"), "raw and gzip"));
  CHECK(mentions(message("encoding: raw", "encoding: gzip"), "gzip"));
  CHECK(mentions(message("kinds: domain domain", "kinds: domain RGB-color"), "'RGB-color'"));
  CHECK(mentions(message("(0,2,0)", "(0,2)"), "not a vector of 3 numbers"));
  CHECK(mentions(message("(0,2,0)", "none"), "not a vector of 3 numbers"));
  CHECK(mentions(message("(0,2,0)", "(0,0,0)"), "or flat"));
  CHECK(mentions(message("# a comment", "colour: red"), "unknown field 'colour'"));
  CHECK(mentions(message("# a comment", "type: float"), "a second time"));
  CHECK(mentions(message("# a comment", "no colon"), "line 2 of its header"));
  CHECK(mentions(message("# a comment", "byte skip: -2"), "byte skip -2"));
  CHECK(mentions(message("# a comment", "line skip: 1"), "line skip"));
  CHECK(mentions(message("# a comment", "byte skip: 9223372036854775807"), "is truncated"));
  CHECK(mentions(message("# a comment", "data file: %03d.raw 1 9 1"), "several files"));
  CHECK(mentions(message("# a comment", "data file: LIST"), "several files"));
  CHECK(mentions(message("# a comment", "data file: missing.raw"), "no such file"));
  CHECK(mentions(message("# a comment", "data file: /dev/zero"), "not a regular file"));
  CHECK(mentions(refusal(put(directory / "v.nrrd", kNrrd)), "has no data"));
  CHECK(mentions(refusal(put(directory / "v.nrrd", "NRRD0004\n#" + std::string(70000, 'x'))),
                 "more than 65536 bytes"));
}

TEST_CASE("no file of volumes, cut off or altered anywhere, does more than be refused") {
  const TemporaryDirectory directory;
  struct Kind {
    const char* name;
    std::string bytes;
  };
  std::string packed_nrrd = kNrrd;
  packed_nrrd.replace(packed_nrrd.find("raw"), 3, "gzip");
  const std::vector<Kind> kinds = {
      {"v.nii", small_nifti()},
      {"v2.nii", nifti2({2, 3, 4}, 2, 8) + bytes_of_values(kBytes)},
      {"v.nii.gz", gzipped(small_nifti())},
      {"v.nrrd", kNrrd + "\n" + bytes_of_values(kBytes)},
      {"p.nrrd", packed_nrrd + "\n" + gzipped(bytes_of_values(kBytes))},
      {"v.npy", ccvt::io::format_npy_header("|u1", {4, 3, 2}) + bytes_of_values(kBytes)}};
  const std::vector<std::string> words = {"-1",
                                          "0",
                                          "9223372036854775807",
                                          "18446744073709551616",
                                          "1e308",
                                          "nan",
                                          "(",
                                          "((,,)",
                                          "\n\n",
                                          ":",
                                          ":=",
                                          "gzip",
                                          "double",
                                          std::string(3, '\0'),
                                          "\xFF\xFF\xFF\x7F"};
  ccvt::Random random(11);
  for (const Kind& kind : kinds) {
    const auto path = directory / kind.name;
    CHECK(refusal(put(path, kind.bytes)).empty());
    for (std::size_t length = 0; length < kind.bytes.size(); ++length) {
      const std::string message = refusal(put(path, kind.bytes.substr(0, length)));
      if (message.empty()) FAIL_CHECK(kind.name << " cut to " << length << " bytes was taken");
    }
    for (int round = 0; round < 400; ++round) {
      std::string bytes = kind.bytes;
      for (std::uint64_t changes = 1 + random.below(4); changes > 0; --changes) {
        const std::size_t at = random.below(bytes.size());
        switch (random.below(4)) {
          case 0:
            bytes[at] = static_cast<char>(random.next());
            break;
          case 1:
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
            break;
          case 2:
            bytes.erase(at, random.below(8));
            bytes += bytes.empty() ? "x" : "";
            break;
          default:
            bytes.insert(at, words[random.below(words.size())]);
        }
      }
      try {
        const Volume volume = read_volume(put(path, bytes));
        const bool bounded = volume.data.size() <= 1032 * bytes.size() + 65536;
        if (!bounded || volume.data.size() != volume.bytes()) FAIL_CHECK("promised too much");
      } catch (const InvalidInput& error) {
        const std::string message = error.what();
        if (!mentions(message, kind.name) && !mentions(message, "no such file")) {
          FAIL_CHECK(message);
        }
      }
    }
  }
}

TEST_SUITE_END();
