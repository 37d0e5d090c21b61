// Measures the difference of two pictures, as numbers and in the colour map of Lee and Ihm, Figure 11.
#pragma once

#include <array>
#include <cstdint>

#include "image/image.h"

namespace kiln {

struct ImageDifference {
  /// Over all channels of linear premultiplied RGBA, peak 1. unit: dB; infinity if equal.
  double psnr_db = 0;
  /// As psnr_db, over RGB of the pixels where either alpha exceeds 1/255.
  double foreground_psnr_db = 0;
  double largest = 0;                // over all channels
  std::size_t differing = 0;         // pixels with any difference
  std::size_t foreground = 0;        // pixels where either alpha exceeds 1/255
  double mean_brightness_ratio = 1;  // sum of b's RGB over sum of a's
};

/// throws: Error kUsage if the sizes differ.
ImageDifference compareImages(const Image& a, const Image& b);

/// Histogram of pixel distances as in `differenceImage`: Euclidean RGB distance of display values, 0 to 255 a channel.
struct DistanceHistogram {
  /// [0] distance 0, [i] distance above i-1 and at most i, [9] above 8.
  std::array<std::uint64_t, 10> pixels{};
  double largest = 0;
  void add(const DistanceHistogram& other);
};

/// throws: Error kUsage if the sizes differ.
DistanceHistogram distanceHistogram(const Image& a, const Image& b);

/// Maps the Euclidean RGB distance of each pixel, from 8-bit display (sRGB) values, to a colour: 0 white, 1 yellow, 2
/// green, 3 cyan, 4 blue, 5 magenta, 6 red, 7 grey, above 8 black, linear in between. source: Lee and Ihm §3.3.
Image differenceImage(const Image& a, const Image& b);

}  // namespace kiln
