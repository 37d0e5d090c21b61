// Problem. A deep picture holds several samples per pixel, from front to back, and the number of layers has no bound.
// Method. When a pixel has more samples than its bound, the two neighbours whose merging changes the picture least
// become one sample.
// Invariant. Samples composited front to back give the flat pixel, before and after merging.
// Differs only for a program that inserts an object between samples: merging moves part of a colour in front of or
// behind the object. Each sample stores a bound of that error.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "image/image.h"
#include "image/pixel_lists.h"
#include "image/pixel_rect.h"

namespace kiln {

/// One layer, filled evenly between its two depths. unit: world, along the view; premultiplied RGBA.
struct DeepSample {
  float z = 0, z_back = 0;
  std::array<float, 4> rgba{};
};

class DeepSamples {
 public:
  /// Samples for the pixels of `rect`. `origin_depth` is added to the depths of copied samples.
  DeepSamples(const PixelRect& rect, const DeepBound& bound, double origin_depth = 0);
  /// Upper bound of the memory for so many pixels. unit: bytes.
  static std::uint64_t bytesFor(std::uint64_t pixels, const DeepBound& bound);

  const PixelRect& rect() const { return lists_.rect(); }
  /// Adds a layer behind all layers of the pixel. The layer changes the composite of the pixel from `before` to
  /// `after`.
  /// shape: premultiplied RGBA.
  /// thread: one thread at a time in each square of 64×64 pixels, counted from pixel (0, 0).
  void add(int x, int y, float z, float z_back, const float* before, const float* after);
  int count(int x, int y) const { return lists_.count(x, y); }
  /// Writes the samples of the pixel from front to back. shape: `out` has room for count(x, y).
  void copy(int x, int y, DeepSample* out) const;

 private:
  // A positive number as the upper half of a float, rounded up.
  using PackedError = std::uint16_t;
  struct MergedSample {
    DeepSample sample;
    PackedError error;        // error of all mergings so far
    PackedError merge_error;  // error of a merging with the next sample
  };

  static PackedError packError(float v);
  static float unpackError(PackedError v);
  static MergedSample merged(const MergedSample& a, const MergedSample& b);
  static PackedError mergeError(const MergedSample& a, const MergedSample& b, float in_front);

  void mergeLeast(int x, int y, const MergedSample& sample, float open);

  const DeepBound bound_;
  const double origin_depth_;
  PixelLists<MergedSample> lists_;
};

}  // namespace kiln
