#include "io/gadget.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "io/input_file.h"
#include "io/output_file.h"

namespace ccvt::io {

static_assert(std::endian::native == std::endian::little);

namespace {

constexpr std::uint32_t kHeaderBytes = 256;
constexpr std::uint32_t kLabelBytes = 8;
constexpr std::uint64_t kMostRecordBytes = std::numeric_limits<std::int32_t>::max();

// Where the header has what, in bytes.
constexpr std::size_t kCounts = 0;
constexpr std::size_t kMasses = 24;
constexpr std::size_t kTime = 72;
constexpr std::size_t kRedshift = 80;
constexpr std::size_t kTotals = 96;
constexpr std::size_t kFiles = 124;
constexpr std::size_t kBoxSize = 128;
constexpr std::size_t kHubble = 152;
constexpr std::size_t kDoublePrecision = 196;  // since GADGET-3

class Header {
 public:
  template <class Value>
  void put(std::size_t at, const Value& value) {
    std::memcpy(&bytes_.at(at), &value, sizeof value);
  }
  template <class Value>
  [[nodiscard]] Value get(std::size_t at) const {
    Value value{};
    std::memcpy(&value, &bytes_.at(at), sizeof value);
    return value;
  }
  [[nodiscard]] char* data() { return bytes_.data(); }
  [[nodiscard]] std::string_view bytes() const { return {bytes_.data(), bytes_.size()}; }

 private:
  std::array<char, kHeaderBytes> bytes_{};
};

Header header_of(const ParticleLoad& load, bool wide) {
  Header header;
  const auto counts = load.by_type(static_cast<std::uint32_t>(load.count()));
  header.put(kCounts, counts);
  header.put(kMasses, load.by_type(load.mass()));
  header.put(kTime, 1 / (1 + load.options().redshift));
  header.put(kRedshift, load.options().redshift);
  header.put(kTotals, counts);
  header.put(kFiles, std::int32_t{1});
  header.put(kBoxSize, load.options().box_size);
  header.put(kHubble, 1.0);
  header.put(kDoublePrecision, std::int32_t{wide ? 1 : 0});
  return header;
}

/// Records, each with a label in front of it in format 2.
class Records {
 public:
  Records(OutputFile& file, bool labels) : file_(file), labels_(labels) {}

  void begin(std::string_view label, std::uint64_t bytes) {
    bytes_ = static_cast<std::uint32_t>(bytes);
    if (labels_) {
      // Behind the label, what to skip to the next one.
      put(kLabelBytes);
      file_.write(label);
      put(bytes_ + 8);
      put(kLabelBytes);
    }
    put(bytes_);
  }
  void end() { put(bytes_); }

 private:
  void put(std::uint32_t value) { file_.write(&value, sizeof value); }

  OutputFile& file_;
  bool labels_;
  std::uint32_t bytes_ = 0;
};

/// A record of `width` values for each particle; fill(first, values) makes those from `first` on.
template <class Value, class Fill>
void write_record(OutputFile& file, Records& records, std::string_view label,
                  const ParticleLoad& load, std::size_t width, const Fill& fill) {
  records.begin(label, load.count() * width * sizeof(Value));
  std::vector<Value> values;
  for_blocks(load, [&](std::uint64_t first, std::size_t number) {
    values.resize(number * width);
    fill(first, std::span<Value>(values));
    file.write(values.data(), values.size() * sizeof(Value));
  });
  records.end();
}

}  // namespace

void check_gadget_size(const std::filesystem::path& path, std::uint64_t particles,
                       std::size_t scalar_bytes) {
  const std::uint64_t most = kMostRecordBytes / (3 * scalar_bytes);
  if (particles <= most) return;
  throw InvalidInput(path.string() + ": " + std::to_string(particles) +
                     " particles are more than the " + std::to_string(most) +
                     " that a record of a GADGET file holds as float" +
                     std::to_string(8 * scalar_bytes) + "; .hdf5 holds them");
}

template <class Real>
void write_gadget(const std::filesystem::path& path, const ParticleLoad& load) {
  OutputFile file(path);
  Records records(file, load.options().gadget_format == 2);
  records.begin("HEAD", kHeaderBytes);
  file.write(header_of(load, sizeof(Real) == 8).bytes());
  records.end();
  const auto zeros = [](std::uint64_t, std::span<Real>) {};  // as they are made
  write_record<Real>(file, records, "POS ", load, 3,
                     [&](std::uint64_t first, std::span<Real> xyz) { load.positions(first, xyz); });
  write_record<Real>(file, records, "VEL ", load, 3, zeros);
  write_record<std::uint32_t>(
      file, records, "ID  ", load, 1, [](std::uint64_t first, std::span<std::uint32_t> numbers) {
        std::iota(numbers.begin(), numbers.end(), static_cast<std::uint32_t>(first + 1));
      });
  if (load.options().type == ParticleType::gas) {
    write_record<Real>(file, records, "U   ", load, 1, zeros);
  }
  file.commit();
}

template void write_gadget<float>(const std::filesystem::path&, const ParticleLoad&);
template void write_gadget<double>(const std::filesystem::path&, const ParticleLoad&);

namespace {

/// An open file, its positions next.
class GadgetInput {
 public:
  explicit GadgetInput(const std::filesystem::path& path) : file_(path) {
    std::uint32_t first = length();
    const bool labels = first == kLabelBytes;
    if (labels) {
      take(kLabelBytes);
      expect(kLabelBytes);
      first = length();
    }
    if (first != kHeaderBytes) {
      file_.fail(first == 0x10000U || first == 0x8000000U
                     ? "is big endian; only little endian is supported"
                     : "is no GADGET file: its header has no 256 bytes");
    }
    take_into(header_.data(), kHeaderBytes);
    expect(kHeaderBytes);
    check_header();
    bytes_ = labels ? find_positions() : length();
    if (bytes_ != 12 * points_.count && bytes_ != 24 * points_.count) {
      file_.fail("its positions have " + std::to_string(bytes_) + " bytes; " +
                 std::to_string(points_.count) + " particles take 12 or 24 times as many");
    }
    check_rest();
    points_.scalar = bytes_ == 12 * points_.count ? ScalarType::float32 : ScalarType::float64;
  }

  [[nodiscard]] const PointsHeader& points() const { return points_; }

  template <class Stored, class Scalar>
  void read(PointsMap<Scalar> points) {
    if constexpr (std::is_same_v<Stored, Scalar>) {
      take_into(points.data(), bytes_);
    } else {
      Points<Stored> block;
      constexpr auto step = static_cast<Eigen::Index>(ParticleLoad::kBlock);
      for (Eigen::Index first = 0; first < points.cols(); first += step) {
        block.resize(3, std::min(step, points.cols() - first));
        take_into(block.data(), static_cast<std::size_t>(block.size()) * sizeof(Stored));
        points.middleCols(first, block.cols()) = block.template cast<Scalar>();
      }
    }
    expect(bytes_);
  }

 private:
  void take_into(void* data, std::size_t count) {
    file_.read(data, count);
    at_ += count;
  }
  std::string take(std::size_t count) {
    std::string bytes(count, '\0');
    take_into(bytes.data(), count);
    return bytes;
  }
  std::uint32_t length() {
    std::uint32_t value = 0;
    take_into(&value, sizeof value);
    return value;
  }
  /// The length behind a record.
  void expect(std::uint64_t bytes) {
    const std::uint32_t value = length();
    if (value == bytes) return;
    file_.fail("a record of " + std::to_string(bytes) + " bytes has " + std::to_string(value) +
               " behind it; both must agree");
  }

  void check_header() {
    const auto counts = header_.get<std::array<std::uint32_t, 6>>(kCounts);
    points_.dimension = 3;
    points_.count = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    if (points_.count == 0) file_.fail("has no particles");
    if (points_.count > std::numeric_limits<Index>::max()) {
      file_.fail("has " + std::to_string(points_.count) +
                 " particles; at most 2147483647 are supported");
    }
    const auto files = header_.get<std::int32_t>(kFiles);
    if (files > 1) {
      file_.fail("is one of " + std::to_string(files) + " files; only all in one are supported");
    }
    const auto box = header_.get<double>(kBoxSize);
    if (box > 0 && std::isfinite(box)) points_.box.assign(3, box);
  }

  /// What is behind the positions is not read, but has to be there: records to the file's last
  /// byte.
  void check_rest() {
    const std::uint64_t size = file_.size();
    std::uint64_t at = at_ - sizeof(std::uint32_t);
    file_.go_to(at);
    while (at < size) {
      std::uint32_t bytes = 0;
      if (size - at >= 2 * sizeof bytes) file_.read(&bytes, sizeof bytes);
      if (size - at < 2 * sizeof bytes || bytes > size - at - 2 * sizeof bytes) {
        file_.fail("is truncated: it ends in the middle of its data");
      }
      file_.skip(bytes + sizeof bytes);
      at += bytes + 2 * sizeof bytes;
    }
    file_.go_to(at_);
  }

  /// Skips what is before them; their length.
  std::uint32_t find_positions() {
    for (;;) {
      expect_label_length();
      const std::string label = take(4);
      take(4);
      expect(kLabelBytes);
      const std::uint32_t bytes = length();
      if (label == "POS ") return bytes;
      if (bytes > file_.size() - at_) file_.fail("has no block 'POS '");
      file_.skip(bytes);
      at_ += bytes;
      expect(bytes);
      if (at_ == file_.size()) file_.fail("has no block 'POS '");
    }
  }
  void expect_label_length() {
    if (length() != kLabelBytes) file_.fail("has a block without a label of 8 bytes");
  }

  InputFile file_;
  Header header_;
  PointsHeader points_;
  std::uint64_t at_ = 0;
  std::uint64_t bytes_ = 0;  ///< of the positions
};

}  // namespace

PointsHeader inspect_gadget_points(const std::filesystem::path& path) {
  return GadgetInput(path).points();
}

template <class Scalar>
PointsMap<Scalar> read_gadget_points(const std::filesystem::path& path,
                                     const detail::Allocation<Scalar>& allocation) {
  GadgetInput input(path);
  PointsMap<Scalar> points = allocate(allocation, input.points());
  if (input.points().scalar == ScalarType::float32) {
    input.read<float>(points);
  } else {
    input.read<double>(points);
  }
  return points;
}

template PointsMap<float> read_gadget_points(const std::filesystem::path&,
                                             const detail::Allocation<float>&);
template PointsMap<double> read_gadget_points(const std::filesystem::path&,
                                              const detail::Allocation<double>&);

}  // namespace ccvt::io
