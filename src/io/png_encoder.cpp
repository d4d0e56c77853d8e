#include <png.h>

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "io/output_file.h"
#include "io/picture.h"

namespace ccvt::io {

namespace {

/// What libpng's callbacks write to and leave behind.
struct Sink {
  OutputFile* file;
  std::exception_ptr thrown;
  char error[128] = "";
};

[[noreturn]] void leave(png_structp png, png_const_charp message) {
  Sink& sink = *static_cast<Sink*>(png_get_error_ptr(png));
  std::snprintf(sink.error, sizeof sink.error, "%s", message);
  png_longjmp(png, 1);
}

void ignore(png_structp /*png*/, png_const_charp /*message*/) {}

void write_bytes(png_structp png, png_bytep data, std::size_t count) {
  Sink& sink = *static_cast<Sink*>(png_get_io_ptr(png));
  try {
    sink.file->write(data, count);
    return;
  } catch (...) {
    sink.thrown = std::current_exception();
  }
  png_error(png, "cannot be written");  // not within the handler: it never returns
}

void flush(png_structp /*png*/) {}

class Writing {
 public:
  explicit Writing(Sink& sink)
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, leave, ignore)),
        info_(png_ != nullptr ? png_create_info_struct(png_) : nullptr) {
    if (info_ == nullptr) {
      png_destroy_write_struct(&png_, nullptr);
      throw std::bad_alloc();
    }
  }
  Writing(const Writing&) = delete;
  Writing& operator=(const Writing&) = delete;
  ~Writing() { png_destroy_write_struct(&png_, &info_); }

  /// False when libpng left in the middle.
  bool write(Sink& sink, int width, int height, int channels, const std::uint8_t* samples) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, &sink, write_bytes, flush);
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
                 channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    const std::ptrdiff_t row = std::ptrdiff_t{channels} * width;
    for (int y = 0; y < height; ++y) png_write_row(png_, samples + y * row);
    png_write_end(png_, info_);
    return true;
  }

 private:
  png_structp png_;
  png_infop info_;
};

}  // namespace

void encode_png(OutputFile& file, int width, int height, int channels,
                const std::uint8_t* samples) {
  Sink sink{.file = &file, .thrown = nullptr};
  Writing writing(sink);
  if (writing.write(sink, width, height, channels, samples)) return;
  if (sink.thrown) std::rethrow_exception(sink.thrown);
  throw std::runtime_error(std::string("PNG: cannot be encoded: ") + sink.error);
}

}  // namespace ccvt::io
