// The drawing of a frame, piece of the picture by piece of the picture: the part that is done once for a frame, the
// visibility structure of a piece, and the costs. The pass (frame/pass) draws the pieces.
#pragma once

#include <memory>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "frame/pass/frame_pass.h"
#include "frame/pass/frame_request.h"
#include "image/image.h"

namespace kiln {

class FrameDrawing {
 public:
  /// requires: the arguments outlive the object; no other user of the cache.
  FrameDrawing(BrickCache& cache, const FrameRequest& request, Progress& progress);

  /// Draws pixels without background, their planes as sums (engine/shared/aov_pixels.h). requires: not empty, in the
  /// picture. throws: as renderFrame.
  Image draw(const PixelRect& pixels);
  /// A rectangle around all pixels of the last piece that show something; colours outside are zero.
  const PixelRect& shown() const { return shown_; }
  /// Returns the cost of all pieces without times, and stops prefetching.
  FrameStatistics finish();

 private:
  /// Makes the visibility structure of a piece, without closed pixels.
  std::unique_ptr<Visibility> visibilityOf(const PixelRect& pixels) const;

  BrickCache& cache_;
  const FrameRequest& request_;
  Progress& progress_;
  const std::unique_ptr<FramePass> pass_;
  const CacheCounts before_;
  PassCosts costs_;
  PixelRect shown_;
};

}  // namespace kiln
