#pragma once

#include "ccvt/io.h"
#include "ccvt/types.h"

namespace ccvt::cli {

/// The side x side blocks of a picture as vectors of 3 side^2 values in [0, 255], blocks row by
/// row, pixels row by row in a block. At the right and lower border the last pixels repeat.
Points<float> blocks_of(const ColourImage& image, int side);

/// The picture that blocks make, without what is beyond its border.
ColourImage picture_of(const Points<double>& blocks, int width, int height, int side);

/// 10 log10(255^2 / mean squared error) in dB, over all pixels and colours;
/// infinite for equal pictures.
double peak_signal_to_noise(const ColourImage& a, const ColourImage& b);

}  // namespace ccvt::cli
