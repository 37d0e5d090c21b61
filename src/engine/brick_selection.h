// The bricks that an engine draws: conditions on levels, values and places, which `traverse` follows front to back.
#pragma once

#include <cstdint>
#include <functional>

#include "grid/coords.h"
#include "image/pixel_rect.h"
#include "store/brick_index.h"

namespace kiln {

/// Use of a brick of one level by a frame.
struct BrickUse {
  bool itself = false;  // the brick is drawn
  bool finer = false;   // finer bricks in its place are drawn, before the brick
};
/// Selects the level of a place: the use of a brick of `level` with the voxels of `box`.
using ChooseLevel = std::function<BrickUse(int level, const VoxelBox& box)>;

/// Tests a rectangle of the picture's plane.
using RectTest = std::function<bool(const PixelRect&)>;
/// Returns whether any part of a brick with the voxels of `core` is interesting and its pixels pass the test. The test
/// receives all pixels that the part can touch, and perhaps more.
using VisiblePart = std::function<bool(int level, const VoxelBox& core, const BrickEntry& entry, const RectTest& test)>;

struct BrickSelection {
  ChooseLevel choose_level;
  VisiblePart visible_part;
  std::int64_t ghosts = 0;  // reach of a drawn brick beyond the footprints of its own voxels. unit: voxels
};

}  // namespace kiln
