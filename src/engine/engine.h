// The interface of engines: ways to turn bricks into pixels. The frame chooses bricks, their order and the tiles
// (frame/pass); an engine knows what a brick shows in a tile. `frame/pass/make_pass.cpp` selects a frame's engine.
// Invariant. A pixel depends on the bricks in front of it, never on tiles, threads, or the bricks drawn together.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "engine/brick_selection.h"
#include "engine/shared/draw_counts.h"
#include "engine/shared/tile_pixels.h"
#include "grid/coords.h"
#include "occlusion/visibility.h"
#include "store/bricked_volume.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// A brick whose turn has come.
struct BrickToDraw {
  StoredBrick brick;
  PixelRect rect;                           // the pixels that it can touch
  std::shared_ptr<const BrickBlock> block;  // null: a constant brick of an engine that draws it from the index
};

/// Data of a brick that all its tiles share. Each engine derives its own.
class PreparedBrick {
 public:
  virtual ~PreparedBrick() = default;
};

/// A tile, and the state of its pixels. One thread has it while an engine draws.
struct TileTarget {
  TilePixels pixels;
  Visibility& visibility;        // closed pixels; null methods close nothing
  float opacity_threshold = 1;   // alpha at which a pixel is closed, above 0
  std::span<DrawCounts> counts;  // shape: one for each brick
};

class Engine {
 public:
  virtual ~Engine() = default;

  /// Makes the data that the tiles of a brick share. requires: this outlives the result. thread: safe.
  virtual std::unique_ptr<const PreparedBrick> prepare(const BrickToDraw& brick) const = 0;
  /// Draws bricks that this engine prepared into a tile. Counts drawn samples in `DrawCounts::splats`: a frame without
  /// any is reported as empty. requires: every nearer brick of the tile is drawn; `bricks` come from front to back.
  /// thread: tiles in parallel; a tile has one thread.
  virtual void draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) = 0;
  /// Memory that the threads have drawn with so far, at most. unit: bytes.
  virtual std::uint64_t scratchBytes() const { return 0; }
};

/// An engine for one volume, whose bricks `traverse/brick_walk.h` finds.
class VolumeEngine : public Engine {
 public:
  /// requires: this outlives the result.
  virtual BrickSelection selection() const = 0;
  /// Returns true if neighbouring tiles take less time as one tile, and no more memory.
  virtual bool joinsTiles() const { return false; }
};

}  // namespace kiln
