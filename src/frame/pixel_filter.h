// Problem: turn the samples (sub-pixels) of a picture into pixels.
// Method: the mean of a pixel's samples. Rays sample points, and get a Gaussian over the samples in and around the
// pixel. Rows and columns have the same weights, except with two rays in quincunx (Sampling::quincunx).
// Invariant: one Highway source without fused operations, so all instruction sets give equal bits.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/capabilities.h"
#include "image/image.h"
#include "image/pixel_rect.h"
#include "job/render_job.h"
#include "scene/camera/camera.h"

namespace kiln {

class PixelFilter {
 public:
  /// Makes the filter for `samples` a pixel: 1, 4 or 16; for rays also 2. requires: `of_rays` with 2.
  /// throws: as subPixelsAlongEdge.
  PixelFilter(int samples, bool of_rays);

  /// Samples along a pixel's edge.
  int edge() const { return edge_; }
  /// Margin of contributing samples on each side of a pixel.
  int reach() const { return reach_; }
  /// Returns true if a pixel equals its sample.
  bool none() const { return edge_ == 1 && reach_ == 0; }
  /// Returns true if pixels and samples are equal in number, so that pixels can replace samples in place.
  bool inPlace(const PixelRect& pixels, const ImageSize& size) const {
    return edge_ == 1 && samplesOf(pixels, size) == pixels;
  }
  /// Returns the samples of these pixels inside a picture of `size`. unit: samples.
  PixelRect samplesOf(const PixelRect& pixels, const ImageSize& size) const;

  /// Writes `pixels` into the image's rows from `row` on. Samples beyond the picture's edge are mirrored. shape:
  /// `samples` has samplesOf(pixels); the image is as wide as `pixels`. requires: the rows are zero, and samples
  /// outside `shown` are zero. unit: samples of the picture.
  void put(const Image& samples, const PixelRect& shown, const PixelRect& pixels, Image& image, int row) const;
  /// Filters a whole picture in place.
  void apply(Image& image, const PixelRect& shown) const;
  /// Upper bound for what `apply` copies of a picture. unit: bytes.
  static std::uint64_t copiedBytes(const ImageSize& size);

 private:
  static constexpr int kMostTaps = 4;
  /// Rows of a task: a few tasks for each thread, with few shared rows. unit: rows.
  static int rowsTogether(int height);
  class Rows;
  int taps() const { return edge_ + 2 * reach_; }
  int edge_ = 1, reach_ = 0;
  bool quincunx_ = false;
  std::array<float, kMostTaps> weights_{};  // weights along a line, from the first sample that contributes
};

/// Returns the filter of the engine's pictures. `filters_rays`: false for pictures whose pixels are rays themselves,
/// such as deep images and panoramas. throws: as PixelFilter.
PixelFilter pixelFilterOf(const EngineChoice& engine, int samples, bool filters_rays = true);

/// Returns bands of rows, in pixels, to draw in turn: `pixels` themselves if they replace their samples in place. Bands
/// of sub-pixels end at borders of tiles, hence at borders of pixels. `band_px`: as FrameRequest.
std::vector<PixelRect> bandsOf(const PixelRect& pixels, const ImageSize& size, const PixelFilter& filter, int band_px);
/// Returns the size of the largest such band if `pixels` are drawn in bands. unit: sub-pixels.
ImageSize bandSize(const PixelRect& pixels, const PixelFilter& filter, int band_px);

}  // namespace kiln
