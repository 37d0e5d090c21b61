// What a pixel makes of the samples of its picture (sub-pixels): their mean, or of rays, each of which sees a point,
// the mean of those in and around it by a Gaussian. The weights of rows and of columns are the same, but where two rays
// a pixel are in quincunx (Sampling::quincunx). One implementation in Highway, without fused operations: all
// instruction sets give the same bits.
#pragma once

#include <array>
#include <cstdint>

#include "image/image.h"
#include "image/pixel_rect.h"
#include "job/render_job.h"
#include "scene/camera/camera.h"

namespace kiln {

class PixelFilter {
 public:
  /// `samples` a pixel: 1, 4 or 16, of rays also 2. throws: Error kUsage where it is none of them.
  PixelFilter(int samples, bool of_rays);

  /// Samples along a pixel's edge.
  int edge() const { return edge_; }
  /// So many samples beside a pixel are parts of it, too.
  int reach() const { return reach_; }
  /// Whether a pixel is its sample.
  bool none() const { return edge_ == 1 && reach_ == 0; }
  /// Whether these pixels are made of as many samples, so that they take their place.
  bool inPlace(const PixelRect& pixels, const ImageSize& size) const {
    return edge_ == 1 && samplesOf(pixels, size) == pixels;
  }
  /// The samples of these pixels of a picture of `size`, as far as it has them. unit: samples.
  PixelRect samplesOf(const PixelRect& pixels, const ImageSize& size) const;

  /// Writes what `pixels` are into the image's rows from `row` on. shape: `samples` has samplesOf(pixels); the image is
  /// as wide as `pixels`. Beyond the picture's edge is what is at it. requires: the rows are zero, as samples are
  /// outside of `shown`. unit: samples of the picture.
  void put(const Image& samples, const PixelRect& shown, const PixelRect& pixels, Image& image, int row) const;
  /// The same of a whole picture in place.
  void apply(Image& image, const PixelRect& shown) const;
  /// What `apply` copies of a picture, at the most. unit: bytes.
  static std::uint64_t copiedBytes(const ImageSize& size);

 private:
  static constexpr int kMostTaps = 4;
  /// So many at a time: a few for each thread, and what they share is little. unit: rows.
  static int rowsTogether(int height);
  class Rows;
  int taps() const { return edge_ + 2 * reach_; }
  int edge_ = 1, reach_ = 0;
  bool quincunx_ = false;
  std::array<float, kMostTaps> weights_{};  // of the samples along a line, from the first that is part of a pixel
};

/// The filter of a picture's pixels. throws: as PixelFilter.
PixelFilter pixelFilterOf(Mode mode, Lattice lattice, int samples);

}  // namespace kiln
