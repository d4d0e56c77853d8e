#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/formats.h"
#include "io/volume_file.h"
#include "number_text.h"

namespace ccvt::io {

namespace {

/// The fields of a header, in either byte order.
class Fields {
 public:
  Fields(std::span<const std::byte> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

  template <class Value>
  [[nodiscard]] Value at(std::size_t offset) const {
    std::array<std::byte, sizeof(Value)> raw{};
    std::memcpy(raw.data(), bytes_.data() + offset, sizeof(Value));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    Value value{};
    std::memcpy(&value, raw.data(), sizeof(Value));
    return value;
  }

 private:
  std::span<const std::byte> bytes_;
  bool swapped_;
};

/// What both versions of the format say, at different places.
struct Nifti {
  std::array<std::int64_t, 8> dim{};
  int datatype = 0;
  int bitpix = 0;
  std::array<double, 8> pixdim{};
  double data_offset = 0;
  double slope = 0;
  double intercept = 0;
  int qform_code = 0;
  int sform_code = 0;
  std::array<double, 3> quaternion{};
  std::array<double, 3> qoffset{};
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> sform;
};

constexpr int kHeader1 = 348;
constexpr int kHeader2 = 540;

Nifti parse_version1(const Fields& f) {
  Nifti n;
  for (std::size_t i = 0; i < 8; ++i) {
    n.dim[i] = f.at<std::int16_t>(40 + 2 * i);
    n.pixdim[i] = f.at<float>(76 + 4 * i);
  }
  n.datatype = f.at<std::int16_t>(70);
  n.bitpix = f.at<std::int16_t>(72);
  n.data_offset = f.at<float>(108);
  n.slope = f.at<float>(112);
  n.intercept = f.at<float>(116);
  n.qform_code = f.at<std::int16_t>(252);
  n.sform_code = f.at<std::int16_t>(254);
  for (std::size_t i = 0; i < 3; ++i) {
    n.quaternion[i] = f.at<float>(256 + 4 * i);
    n.qoffset[i] = f.at<float>(268 + 4 * i);
  }
  for (std::size_t k = 0; k < 12; ++k) n.sform.data()[k] = f.at<float>(280 + 4 * k);
  return n;
}

Nifti parse_version2(const Fields& f) {
  Nifti n;
  for (std::size_t i = 0; i < 8; ++i) {
    n.dim[i] = f.at<std::int64_t>(16 + 8 * i);
    n.pixdim[i] = f.at<double>(104 + 8 * i);
  }
  n.datatype = f.at<std::int16_t>(12);
  n.bitpix = f.at<std::int16_t>(14);
  n.data_offset = static_cast<double>(f.at<std::int64_t>(168));
  n.slope = f.at<double>(176);
  n.intercept = f.at<double>(184);
  n.qform_code = f.at<std::int32_t>(344);
  n.sform_code = f.at<std::int32_t>(348);
  for (std::size_t i = 0; i < 3; ++i) {
    n.quaternion[i] = f.at<double>(352 + 8 * i);
    n.qoffset[i] = f.at<double>(376 + 8 * i);
  }
  for (std::size_t k = 0; k < 12; ++k) n.sform.data()[k] = f.at<double>(400 + 8 * k);
  return n;
}

VoxelType type_of(const InputFile& file, int datatype, int bitpix) {
  struct Code {
    int datatype;
    VoxelType type;
  };
  constexpr std::array<Code, 10> codes = {{{2, VoxelType::uint8},
                                           {4, VoxelType::int16},
                                           {8, VoxelType::int32},
                                           {16, VoxelType::float32},
                                           {64, VoxelType::float64},
                                           {256, VoxelType::int8},
                                           {512, VoxelType::uint16},
                                           {768, VoxelType::uint32},
                                           {1024, VoxelType::int64},
                                           {1280, VoxelType::uint64}}};
  for (const Code& code : codes) {
    if (code.datatype != datatype) continue;
    if (std::cmp_equal(bitpix, 8 * bytes_of(code.type))) return code.type;
    file.fail("has values of type " + std::string(to_string(code.type)) + ", but of " +
              std::to_string(bitpix) + " bits (bitpix)");
  }
  if (datatype == 128 || datatype == 2304) {
    file.fail("holds colours (RGB); a field of single numbers is needed");
  }
  if (datatype == 32 || datatype == 1792 || datatype == 2048) {
    file.fail("holds complex numbers; a field of real numbers is needed");
  }
  file.fail("has the data type " + std::to_string(datatype) +
            "; whole numbers and floats of 8 to 64 bits can be read");
}

std::vector<std::int64_t> shape_of(const InputFile& file, const Nifti& n) {
  if (n.dim[0] < 1 || n.dim[0] > 7) {
    file.fail("has " + std::to_string(n.dim[0]) + " dimensions (dim[0]); from 1 to 7 are possible");
  }
  if (n.dim[0] < 3) {
    file.fail("has " + std::to_string(n.dim[0]) + " dimensions; a volume needs 3");
  }
  for (std::size_t d = 1; std::cmp_less_equal(d, n.dim[0]); ++d) {
    if (n.dim[d] < 1) {
      file.fail("has dim[" + std::to_string(d) + "] = " + std::to_string(n.dim[d]) +
                "; must be at least 1");
    }
    if (d > 3 && n.dim[d] > 1) {
      file.fail(d == 4 ? "is a series of " + std::to_string(n.dim[4]) +
                             " volumes (4D); extract one of them first"
                       : "has " + std::to_string(n.dim[d]) + " numbers a voxel (dim[" +
                             std::to_string(d) + "]); a field of single numbers is needed");
    }
  }
  return {n.dim[1], n.dim[2], n.dim[3]};
}

void check_pixdim(const InputFile& file, const Nifti& n) {
  for (std::size_t d = 1; d <= 3; ++d) {
    if (n.pixdim[d] > 0 && std::isfinite(n.pixdim[d])) continue;
    file.fail("has pixdim[" + std::to_string(d) + "] = " + text(n.pixdim[d]) +
              "; spacings must be positive and finite");
  }
}

/// The three methods of the standard: sform, else qform, else index times pixdim.
void place(const InputFile& file, const Nifti& n, Grid& grid) {
  if (n.sform_code > 0) {
    grid.axes = n.sform.leftCols(3);
    grid.origin = n.sform.col(3);
    return;
  }
  check_pixdim(file, n);
  const Eigen::Vector3d spacing(n.pixdim[1], n.pixdim[2], n.pixdim[3]);
  grid.axes = Eigen::Matrix3d(spacing.asDiagonal());
  grid.origin = Eigen::Vector3d::Zero();
  if (n.qform_code <= 0) return;
  const Eigen::Vector3d vector(n.quaternion[0], n.quaternion[1], n.quaternion[2]);
  if (!vector.allFinite() || vector.squaredNorm() > 1.01) {
    file.fail("has the quaternion (" + text(vector[0]) + ", " + text(vector[1]) + ", " +
              text(vector[2]) + "), which is no rotation");
  }
  const double real = std::sqrt(std::max(0.0, 1 - vector.squaredNorm()));
  const Eigen::Quaterniond rotation(real, vector[0], vector[1], vector[2]);
  const double handed = n.pixdim[0] < 0 ? -1 : 1;
  grid.axes = rotation.normalized().toRotationMatrix() *
              Eigen::Vector3d(spacing[0], spacing[1], handed * spacing[2]).asDiagonal();
  grid.origin = Eigen::Vector3d(n.qoffset[0], n.qoffset[1], n.qoffset[2]);
}

}  // namespace

VolumeFile open_nifti(const std::filesystem::path& path) {
  InputFile file(path);
  VolumeFile result;
  result.data = path;
  result.gzip = extension_of(path) == ".gz";
  ByteStream stream(file, file.size(), result.gzip);

  std::vector<std::byte> bytes(kHeader1);
  stream.read(bytes.data(), bytes.size());
  const auto size = Fields(bytes, false).at<std::int32_t>(0);
  const auto swapped_size = Fields(bytes, true).at<std::int32_t>(0);
  result.big_endian = size != kHeader1 && size != kHeader2;
  const bool second = (result.big_endian ? swapped_size : size) == kHeader2;
  if (!second && size != kHeader1 && swapped_size != kHeader1) {
    file.fail("is not a NIfTI file: its header claims " + std::to_string(size) +
              " bytes, not 348 or 540");
  }
  if (second) {
    bytes.resize(kHeader2);
    stream.read(bytes.data() + kHeader1, kHeader2 - kHeader1);
  }
  const std::string_view magic(reinterpret_cast<const char*>(bytes.data()) + (second ? 4 : 344), 4);
  if (magic == std::string_view("ni1\0", 4) || magic == std::string_view("ni2\0", 4)) {
    file.fail("is the header of a pair of files (.hdr, .img); join them into one .nii first");
  }
  if (magic != (second ? std::string_view("n+2\0", 4) : std::string_view("n+1\0", 4))) {
    file.fail("is not a NIfTI file: its magic is " + io::quoted(magic) + ", not 'n+1' or 'n+2'");
  }

  const Fields fields(bytes, result.big_endian);
  const Nifti nifti = second ? parse_version2(fields) : parse_version1(fields);
  result.header.grid.shape = shape_of(file, nifti);
  result.header.type = type_of(file, nifti.datatype, nifti.bitpix);
  place(file, nifti, result.header.grid);
  // A slope of 0 means that there is no scaling; some programs write a NaN instead.
  if (nifti.slope != 0 && !std::isnan(nifti.slope)) {
    result.header.slope = nifti.slope;
    result.header.intercept = nifti.intercept;
  }
  const double least = second ? 544 : 352;
  if (!(nifti.data_offset >= least && nifti.data_offset < 0x1p53) ||
      nifti.data_offset != std::floor(nifti.data_offset)) {
    file.fail("has its data at byte " + text(nifti.data_offset) +
              " (vox_offset); must be a whole number of at least " + text(least));
  }
  result.skip = static_cast<std::uint64_t>(nifti.data_offset);
  check_volume(file, result.header);
  return result;
}

}  // namespace ccvt::io
