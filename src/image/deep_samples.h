// What lies in each pixel, layer by layer: samples from front to back which, laid over one another, are the pixel. A
// pixel keeps a bounded number of them: neighbours become one where that tells least to whoever puts something between
// them. Laid over one another they are the same pixel before and after.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "image/pixel_lists.h"
#include "image/pixel_rect.h"

namespace kiln {

/// A layer by itself, evenly filled between its depths. unit: world, along the view; premultiplied RGBA.
struct DeepSample {
  float z = 0, z_back = 0;
  std::array<float, 4> rgba{};
};

struct DeepBound {
  static constexpr int kMostSamples = 1024;
  int samples = 24;  // of a pixel, at most; from 1 to kMostSamples
  /// Neighbours become one as long as a cut at any depth of the pixel shows in front of it, by this at most, another
  /// value of any channel than the layers themselves. With more layers than `samples` it may be more.
  float error = 0;
};

class DeepSamples {
 public:
  /// Of the pixels of `rect`. `origin_depth` is added to the depths of samples that are copied out.
  DeepSamples(const PixelRect& rect, const DeepBound& bound, double origin_depth = 0);
  /// The most that so many pixels take. unit: bytes.
  static std::uint64_t bytesFor(std::uint64_t pixels, const DeepBound& bound);

  const PixelRect& rect() const { return lists_.rect(); }
  /// A layer that changes what is in front of it, and with it, from `before` to `after`, in depths behind all of the
  /// pixel's others. shape: premultiplied RGBA. thread: one at a time in each square of 64×64 pixels, counted from
  /// pixel (0, 0).
  void add(int x, int y, float z, float z_back, const float* before, const float* after);
  int count(int x, int y) const { return lists_.count(x, y); }
  /// Writes the pixel's samples, from front to back. shape: `out` has room for count(x, y).
  void copy(int x, int y, DeepSample* out) const;

 private:
  // A number above 0, rounded up: the upper half of a float.
  using Rounded = std::uint16_t;
  struct Kept {
    DeepSample sample;
    Rounded error;  // that merging has made so far
    Rounded joint;  // the error of the sample that it would be with the next
  };

  static Rounded rounded(float v);
  static float valueOf(Rounded v);
  static Kept joined(const Kept& a, const Kept& b);
  static Rounded jointError(const Kept& a, const Kept& b, float in_front);

  void joinLeast(int x, int y, const Kept& sample, float open);

  const DeepBound bound_;
  const double origin_depth_;
  PixelLists<Kept> lists_;
};

}  // namespace kiln
