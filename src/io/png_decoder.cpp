#include <png.h>

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <type_traits>
#include <vector>

#include "io/picture.h"

namespace ccvt::io {

namespace {

/// deflate makes at most this many bytes of one.
constexpr std::uint64_t kMostExpansion = 1032;

/// What a stream may go on for after the last row: its end takes a few bytes. libpng would unpack
/// all that follows, though it refuses the picture for it.
constexpr std::size_t kMostSurplus = 4096;

/// As the first chunk of Exif data says, before or behind the picture's own. Its sum is libpng's to
/// check, which reads on to the end.
Orientation orientation_of(std::span<const unsigned char> bytes) {
  constexpr std::size_t kSignature = 8;
  constexpr std::size_t kBeforeData = 8;
  constexpr std::size_t kAround = kBeforeData + 4;
  std::size_t at = kSignature;
  while (bytes.size() >= kAround && at <= bytes.size() - kAround) {
    const std::size_t length = png_get_uint_32(bytes.data() + at);
    if (length > bytes.size() - kAround - at) return {};
    if (std::memcmp(bytes.data() + at + 4, "IEND", 4) == 0) return {};
    if (std::memcmp(bytes.data() + at + 4, "eXIf", 4) == 0) {
      return Orientation(bytes.subspan(at + kBeforeData, length));
    }
    at += kAround + length;
  }
  return {};
}

/// What libpng's callbacks read from and leave behind.
struct Source {
  std::span<const unsigned char> left;
  std::size_t surplus = 0;  ///< bytes of the stream read after the last row
  png_uint_32 height = 0;
  bool interlaced = false;
  bool truncated = false;
  bool out_of_memory = false;
  char warning[128] = "";
  char error[128] = "";
};

void keep_warning(png_structp png, png_const_charp message) {
  Source& source = *static_cast<Source*>(png_get_error_ptr(png));
  std::snprintf(source.warning, sizeof source.warning, "%s", message);
}

[[noreturn]] void leave(png_structp png, png_const_charp message) {
  Source& source = *static_cast<Source*>(png_get_error_ptr(png));
  std::snprintf(source.error, sizeof source.error, "%s", message);
  png_longjmp(png, 1);
}

bool rows_done(png_const_structp png, const Source& source) {
  return source.interlaced ? png_get_current_pass_number(png) >= PNG_INTERLACE_ADAM7_PASSES
                           : png_get_current_row_number(png) >= source.height;
}

void read_bytes(png_structp png, png_bytep data, std::size_t count) {
  Source& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (count > source.left.size()) {
    source.truncated = true;
    png_error(png, "truncated");
  }
  constexpr png_uint_32 idat = 0x49444154;
  if (png_get_io_chunk_type(png) == idat && rows_done(png, source)) {
    source.surplus += count;
    if (source.surplus > kMostSurplus) png_error(png, "IDAT: Too much image data");
  }
  std::memcpy(data, source.left.data(), count);
  source.left = source.left.subspan(count);
}

void* allocate(png_structp png, png_alloc_size_t count) {
  void* const memory = std::malloc(count);
  if (memory == nullptr) static_cast<Source*>(png_get_mem_ptr(png))->out_of_memory = true;
  return memory;
}

void release(png_structp /*png*/, void* memory) { std::free(memory); }

class Reading {
 public:
  explicit Reading(Source& source)
      : png_(png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &source, leave, keep_warning, &source,
                                      allocate, release)),
        info_(png_ != nullptr ? png_create_info_struct(png_) : nullptr) {
    if (info_ == nullptr) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
  }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;
  ~Reading() { png_destroy_read_struct(&png_, &info_, nullptr); }

  /// False when libpng left `step` in its middle.
  template <class Step>
  bool attempt(const Step& step) {
    static_assert(std::is_trivially_destructible_v<Step>);
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    step(png_, info_);
    return true;
  }

  [[nodiscard]] png_structp png() const { return png_; }
  [[nodiscard]] png_infop info() const { return info_; }

 private:
  png_structp png_;
  png_infop info_;
};

class PngDecoder final : public PictureDecoder {
 public:
  PngDecoder(const InputFile& file, std::span<const unsigned char> bytes)
      : file_(file), source_{.left = bytes}, reading_(source_) {
    read_header();
    prepare_rows();
    layout_.orientation = orientation_of(bytes);
  }

  [[nodiscard]] PictureLayout layout() const override { return layout_; }
  const std::uint8_t* next_row() override;
  void finish() override {
    attempt([](png_structp png, png_infop /*info*/) { png_read_end(png, nullptr); });
  }

 private:
  template <class Step>
  void attempt(const Step& step) {
    if (!reading_.attempt(step)) fail();
  }
  [[noreturn]] void fail() const;
  void read_header();
  void prepare_rows();
  void read_all_rows();

  const InputFile& file_;
  Source source_;
  Reading reading_;
  PictureLayout layout_;
  std::size_t row_bytes_ = 0;
  std::size_t rows_read_ = 0;
  std::vector<std::uint8_t> rows_;  ///< one, or all when interlaced
};

void PngDecoder::fail() const {
  if (source_.out_of_memory) throw std::bad_alloc();
  if (source_.truncated) file_.fail("is a truncated PNG: it ends before its IEND chunk");
  std::string message = std::string("is a damaged PNG: ") + source_.error;
  if (source_.warning[0] != '\0') message += std::string(" (") + source_.warning + ")";
  file_.fail(message);
}

void PngDecoder::read_header() {
  attempt([&](png_structp png, png_infop info) {
    png_set_read_fn(png, &source_, read_bytes);
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // for check_size() to judge
    // Of all chunks that may be left out only tRNS is looked at: profiles and texts, compressed or
    // not, are passed over, so they may have any size, but their checksums must be right.
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_set_chunk_malloc_max(png, 0);
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_set_benign_errors(png, 0);  // such as a stream that is longer than the picture
    png_read_info(png, info);
  });
  auto* const png = reading_.png();
  auto* const info = reading_.info();
  const std::uint64_t bits =
      std::uint64_t{png_get_bit_depth(png, info)} * png_get_channels(png, info);
  check_size(file_, png_get_image_width(png, info), png_get_image_height(png, info),
             8 * kMostExpansion * file_.size() / bits);
}

void PngDecoder::prepare_rows() {
  attempt([&](png_structp png, png_infop info) {
    png_set_expand(png);  // palettes, fewer than 8 bits, tRNS
    source_.height = png_get_image_height(png, info);
    source_.interlaced = png_set_interlace_handling(png) > 1;
    png_read_update_info(png, info);
  });
  auto* const png = reading_.png();
  auto* const info = reading_.info();
  layout_.width = png_get_image_width(png, info);
  layout_.height = png_get_image_height(png, info);
  layout_.channels = png_get_channels(png, info);
  layout_.depth = png_get_bit_depth(png, info);
  row_bytes_ = png_get_rowbytes(png, info);
  rows_.resize(row_bytes_ * (source_.interlaced ? layout_.height : 1));
}

void PngDecoder::read_all_rows() {
  attempt([&](png_structp png, png_infop /*info*/) {
    for (int pass = 0; pass < PNG_INTERLACE_ADAM7_PASSES; ++pass) {
      for (std::size_t at = 0; at < rows_.size(); at += row_bytes_) {
        png_read_row(png, rows_.data() + at, nullptr);
      }
    }
  });
}

const std::uint8_t* PngDecoder::next_row() {
  if (source_.interlaced) {
    if (rows_read_ == 0) read_all_rows();
    return rows_.data() + row_bytes_ * rows_read_++;
  }
  attempt([&](png_structp png, png_infop /*info*/) { png_read_row(png, rows_.data(), nullptr); });
  return rows_.data();
}

}  // namespace

std::unique_ptr<PictureDecoder> open_png(const InputFile& file,
                                         std::span<const unsigned char> bytes) {
  return std::make_unique<PngDecoder>(file, bytes);
}

}  // namespace ccvt::io
