// How far two pictures are apart, in numbers and in the colours of Lee and Ihm's Figure 11.
#pragma once

#include <array>
#include <cstdint>

#include "image/image.h"

namespace kiln {

struct ImageDifference {
  /// Over all channels of linear premultiplied RGBA, peak 1. unit: dB; infinity where equal.
  double psnr_db = 0;
  /// The same over RGB of the pixels where either alpha exceeds 1/255.
  double foreground_psnr_db = 0;
  double largest = 0;                // of all channels
  std::size_t differing = 0;         // pixels with any difference at all
  std::size_t foreground = 0;        // pixels where either alpha exceeds 1/255
  double mean_brightness_ratio = 1;  // sum of b's RGB over sum of a's
};

/// throws: Error kUsage where the sizes differ.
ImageDifference compareImages(const Image& a, const Image& b);

/// How many pixels are how far apart, in the measure of `differenceImage`: Euclidean RGB distance of display values, 0
/// to 255 a channel.
struct DistanceHistogram {
  /// [0] equal on a display, [i] apart by more than i-1 and at most i, [9] by more than 8.
  std::array<std::uint64_t, 10> pixels{};
  double largest = 0;
  void add(const DistanceHistogram& other);
};

/// throws: Error kUsage where the sizes differ.
DistanceHistogram distanceHistogram(const Image& a, const Image& b);

/// Euclidean RGB distance of each pixel, 8 bits a channel, in the paper's map: 0 white, 1 yellow, 2 green, 3 cyan, 4
/// blue, 5 magenta, 6 red, 7 grey, above 8 black, linear in between. source: Lee and Ihm §3.3. Distances are of display
/// (sRGB) values.
Image differenceImage(const Image& a, const Image& b);

}  // namespace kiln
