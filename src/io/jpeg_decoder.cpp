#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <new>
#include <string>
#include <type_traits>
#include <vector>

#include "io/picture.h"

// jpeglib.h needs <cstdio> before it.
#include <jerror.h>
#include <jpeglib.h>

namespace ccvt::io {

namespace {

/// A block of 8 x 8 samples takes one bit or more, and there is one for every 128 pixels: one
/// component may have all columns, another all rows, of blocks as sparse as a quarter each.
constexpr std::uint64_t kMostPixelsPerByte = std::uint64_t{8} * 128;
/// Each scan goes over all blocks of the picture, however few bytes it has. Progressive pictures
/// have about ten.
constexpr int kMostScans = 100;
/// For the coefficients of a picture of several scans, 2 bytes each. As many as kMostPixels have.
constexpr long kMostMemory = 1L << 31;
constexpr int kExifMarker = JPEG_APP0 + 1;
constexpr unsigned kMostExif = 0xFFFF;

/// What libjpeg's callbacks leave behind.
struct Failure {
  jpeg_error_mgr manager{};  // first, so that a pointer to it is one to this
  std::jmp_buf jump{};
  char text[JMSG_LENGTH_MAX] = "";
};

[[noreturn]] void leave(j_common_ptr jpeg) {
  Failure& failure = *reinterpret_cast<Failure*>(jpeg->err);
  (*jpeg->err->format_message)(jpeg, failure.text);
  std::longjmp(failure.jump, 1);
}

/// Those that say nothing about the pixels: unknown numbers in headers, and padding that some
/// cameras write between segments. All others mean that pixels are missing or made up.
bool is_harmless(int warning) {
  return warning == JWRN_ADOBE_XFORM || warning == JWRN_JFIF_MAJOR ||
         warning == JWRN_NOT_SEQUENTIAL || warning == JWRN_EXTRANEOUS_DATA;
}

void judge_message(j_common_ptr jpeg, int level) {
  if (level < 0 && !is_harmless(jpeg->err->msg_code)) leave(jpeg);
}

void print_nothing(j_common_ptr /*jpeg*/) {}

constexpr int kTooManyScans = -1;  // no message of libjpeg's

void limit_scans(j_common_ptr jpeg) {
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMostScans) return;
  jpeg->err->msg_code = kTooManyScans;
  leave(jpeg);
}

/// libjpeg's state, and the only place where its errors arrive.
class Decompression {
 public:
  Decompression() {
    jpeg.err = jpeg_std_error(&failure_.manager);
    failure_.manager.error_exit = leave;
    failure_.manager.emit_message = judge_message;
    failure_.manager.output_message = print_nothing;
  }
  Decompression(const Decompression&) = delete;
  Decompression& operator=(const Decompression&) = delete;
  ~Decompression() { jpeg_destroy_decompress(&jpeg); }

  /// Throws InvalidInput when libjpeg left `step` in its middle.
  template <class Step>
  void attempt(const InputFile& file, const Step& step) {
    if (!returns(step)) fail(file);
  }

  jpeg_decompress_struct jpeg{};

 private:
  template <class Step>
  bool returns(const Step& step) {
    static_assert(std::is_trivially_destructible_v<Step>);
    if (setjmp(failure_.jump) != 0) return false;
    step(jpeg);
    return true;
  }
  [[noreturn]] void fail(const InputFile& file) const;

  Failure failure_;
};

void Decompression::fail(const InputFile& file) const {
  switch (failure_.manager.msg_code) {
    case JERR_OUT_OF_MEMORY:
      throw std::bad_alloc();
    case JWRN_JPEG_EOF:
      file.fail("is a truncated JPEG: it ends before its end marker");
    case kTooManyScans:
      file.fail("is a JPEG of more than " + std::to_string(kMostScans) + " scans");
    case JERR_BAD_PRECISION:
      file.fail("is a JPEG of " + std::to_string(failure_.manager.msg_parm.i[0]) +
                " bits a sample; 8 are supported");
    case JERR_SOF_UNSUPPORTED:
      file.fail("is a lossless or hierarchical JPEG; sequential and progressive are supported");
    case JERR_IMAGE_TOO_BIG:
      file.fail("is a JPEG of more than " + std::to_string(failure_.manager.msg_parm.i[0]) +
                " pixels a side");
    default:
      file.fail(std::string("is a damaged JPEG: ") + failure_.text);
  }
}

class JpegDecoder final : public PictureDecoder {
 public:
  JpegDecoder(const InputFile& file, std::span<const unsigned char> bytes);

  [[nodiscard]] PictureLayout layout() const override {
    return {jpeg_.output_width, jpeg_.output_height,
            static_cast<std::size_t>(jpeg_.output_components), 8, orientation_};
  }
  const std::uint8_t* next_row() override {
    attempt([&](jpeg_decompress_struct& jpeg) {
      JSAMPROW row = row_.data();
      jpeg_read_scanlines(&jpeg, &row, 1);
    });
    return row_.data();
  }
  void finish() override {
    attempt([](jpeg_decompress_struct& jpeg) { jpeg_finish_decompress(&jpeg); });
  }

 private:
  template <class Step>
  void attempt(const Step& step) {
    decompression_.attempt(file_, step);
  }
  void check_header() const;
  [[nodiscard]] Orientation read_orientation() const;
  void check_components() const;

  const InputFile& file_;
  jpeg_progress_mgr progress_{};
  Decompression decompression_;
  jpeg_decompress_struct& jpeg_ = decompression_.jpeg;
  std::vector<std::uint8_t> row_;
  Orientation orientation_;
};

JpegDecoder::JpegDecoder(const InputFile& file, std::span<const unsigned char> bytes)
    : file_(file) {
  progress_.progress_monitor = limit_scans;
  attempt([&](jpeg_decompress_struct& jpeg) {
    jpeg_create_decompress(&jpeg);
    jpeg.progress = &progress_;
    jpeg.mem->max_memory_to_use = kMostMemory;
    jpeg_mem_src(&jpeg, bytes.data(), bytes.size());
    jpeg_save_markers(&jpeg, kExifMarker, kMostExif);
    jpeg_read_header(&jpeg, TRUE);
  });
  check_header();
  orientation_ = read_orientation();
  attempt([](jpeg_decompress_struct& jpeg) {
    jpeg.out_color_space = jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg.do_block_smoothing = FALSE;  // that guesses what scans have not told
    jpeg_start_decompress(&jpeg);     // reads all scans if there are several
  });
  check_components();
  const PictureLayout rows = JpegDecoder::layout();
  row_.resize(rows.width * rows.channels);
}

void JpegDecoder::check_header() const {
  if (jpeg_.arith_code != FALSE) {
    file_.fail("is a JPEG with arithmetic codes; only Huffman codes are supported");
  }
  if (jpeg_.num_components == 4) {
    file_.fail("is a JPEG in CMYK, whose colours depend on inks; convert it to RGB or grey");
  }
  if (jpeg_.num_components != 1 && jpeg_.num_components != 3) {
    file_.fail("is a JPEG of " + std::to_string(jpeg_.num_components) +
               " components; 1 (grey) and 3 (colour) are supported");
  }
  check_size(file_, jpeg_.image_width, jpeg_.image_height, kMostPixelsPerByte * file_.size());
}

/// That of the first segment that tells of another than upright.
Orientation JpegDecoder::read_orientation() const {
  for (auto* marker = jpeg_.marker_list; marker != nullptr; marker = marker->next) {
    const Orientation told(std::span<const unsigned char>(marker->data, marker->data_length));
    if (!told.upright()) return told;
  }
  return {};
}

/// libjpeg shows a component that no scan has as even grey.
void JpegDecoder::check_components() const {
  for (int c = 0; c < jpeg_.num_components; ++c) {
    if (jpeg_.comp_info[c].quant_table == nullptr) {
      file_.fail("is a damaged JPEG: no scan has component " + std::to_string(c + 1) + " of " +
                 std::to_string(jpeg_.num_components));
    }
  }
}

}  // namespace

std::unique_ptr<PictureDecoder> open_jpeg(const InputFile& file,
                                          std::span<const unsigned char> bytes) {
  return std::make_unique<JpegDecoder>(file, bytes);
}

}  // namespace ccvt::io
