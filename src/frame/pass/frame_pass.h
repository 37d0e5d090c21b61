// The interface of passes: orders in which a frame draws bricks. A frame has one pass: brick after brick
// (frame/pass/brick_pass.h), zone after zone (frame/pass/zone_pass.h) or by value (frame/pass/value_pass.h).
// Pixels and tiles are counted in the whole picture, so that a pixel is equal, bit for bit, in every piece.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "engine/shared/draw_counts.h"
#include "engine/shared/tile_pixels.h"
#include "frame/pass/frame_statistics.h"
#include "occlusion/visibility.h"
#include "traverse/brick_walk.h"

namespace kiln {

/// A brick of a frame, and the pixels that the brick can touch.
struct BrickOfFrame {
  StoredBrick brick;
  PixelRect rect;
};

/// A piece of the picture to draw.
struct PassTarget {
  TilePixels pixels;
  Visibility& visibility;  // of the piece; no pixel is closed yet
  float opacity_threshold;
};

/// Costs of all pieces of a frame.
struct PassCosts {
  FrameStatistics statistics;  // levels, contributing and damaged bricks
  DrawCounts drawn;
  BrickWalkCounts walked;
};

/// Sources and sinks of a pass. requires: no other user of the cache during a draw.
struct PassContext {
  BrickCache& cache;
  Progress& progress;
  PassCosts& costs;
};

class FramePass {
 public:
  virtual ~FramePass() = default;

  /// Returns the bricks for the pixels if nothing is hidden, each once, and sets the counts.
  virtual std::vector<BrickOfFrame> inView(const PixelRect& pixels, BrickWalkCounts& counts) const = 0;
  /// Returns the total of the progress of `draw` for these pixels (frame/pass/frame_progress.h).
  virtual std::uint64_t steps(const PixelRect& pixels) const = 0;
  /// Draws a piece without background, its planes as sums (engine/shared/aov_pixels.h). Returns a rectangle around all
  /// changed pixels. throws: as BrickCache::get; Error kCancelled; kBudget if the cache has no room for `bytesAtOnce`.
  virtual PixelRect draw(const PassTarget& target, PassContext& context) = 0;
  /// Returns the memory for bricks that must be in the cache together to draw these pixels, beyond the largest brick.
  /// unit: bytes.
  virtual std::uint64_t bytesAtOnce(const PixelRect& /*pixels*/) const { return 0; }
  /// Returns the peak of the threads' scratch memory. unit: bytes.
  virtual std::uint64_t scratchBytes() const = 0;
};

/// The tiles of the whole frame that `rect` touches, cut off at `drawn`. With a `tile_px` of 0, `drawn` is the tile.
std::vector<PixelRect> tilesOf(int tile_px, const PixelRect& drawn, const PixelRect& rect);

}  // namespace kiln
