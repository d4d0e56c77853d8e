#include "ccvt/stipple.h"

#include <algorithm>
#include <cstdint>

#include "ccvt/io.h"
#include "cli/kept_run.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "io/formats.h"
#include "number_text.h"

namespace ccvt::cli {

namespace {

/// Dots that are asked to be small may be paler than a picture of 256 greys can show.
void warn_if_blank(const StippleArguments& arguments, const Image& drawn) {
  constexpr float kWhite = 1 - 0.5F / 255;
  if (std::any_of(drawn.values.begin(), drawn.values.end(), [](float v) { return v < kWhite; })) {
    return;
  }
  warn(arguments.quiet,
       {concat(arguments.output.string(), " is white: its pixels, ", drawn.width, " x ",
               drawn.height, ", are too large for dots of radius ", arguments.dot_radius)});
}

template <class Scalar>
int stipple_file(const StippleArguments& arguments) {
  const KeptRun kept(arguments);
  check_memory(arguments.sites, arguments.points_per_site, 2, sizeof(Scalar));
  const Image image = read_image(arguments.image);

  StippleOptions options;
  options.points_per_site = arguments.points_per_site;
  options.invert = arguments.invert;
  options.gamma = arguments.gamma;
  options.dot_radius = arguments.dot_radius;
  const Stippling<Scalar> stippling = kept.blame(arguments.image, [&] {
    Progress progress(arguments.quiet, arguments.time_limit);
    options.tessellation = kept.options(
        make_options(arguments, options.tessellation, arguments.sites, progress), progress);
    return stipple<Scalar>(image, arguments.sites, options);
  });

  Publication outputs;
  const PutBack put_back{stippling.put_back, stippling.farthest_put_back};
  write_summary(arguments, stippling.summary, put_back);
  const std::string extension = io::extension_of(arguments.output);
  if (extension == ".svg") {
    write_svg(arguments.output, stippling);
  } else if (extension == ".png") {
    const Image drawn = render(stippling);
    write_png(arguments.output, drawn);
    warn_if_blank(arguments, drawn);
  } else {
    write_points(arguments.output, stippling.dots);
  }
  const int status = finish(arguments, outputs, stippling.summary, put_back);
  kept.end(stippling.summary);
  return status;
}

}  // namespace

int run_stipple(const StippleArguments& arguments) {
  const std::string extension = io::extension_of(arguments.output);
  if (arguments.dot_radius > 0 && extension != ".svg" && extension != ".png") {
    throw InvalidInput("--dot-radius: dots are drawn into .svg and .png, not into " + extension);
  }
  Outputs()
      .add("--output", arguments.output, io::kStippleFiles)
      .add("--summary", arguments.summary)
      .add_input("IMAGE", arguments.image)
      .add_input("--checkpoint", checkpoint_file(arguments))
      .check();
  return arguments.scalar == ScalarType::float64 ? stipple_file<double>(arguments)
                                                 : stipple_file<float>(arguments);
}

}  // namespace ccvt::cli
