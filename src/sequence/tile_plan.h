// Problem: share the pixels of a job's frames among ranks so that few bricks are read twice.
// Method: bisect the picture, each time at the cut of about even work that reads the fewest bytes. A rank has the same
// rectangle in every frame, so its bricks stay in memory. The plan uses the index alone and ignores occlusion.
#pragma once

#include <cstdint>
#include <vector>

#include "image/pixel_rect.h"
#include "sequence/opened_job.h"

namespace kiln {

struct TilePlan {
  /// Number of a rank's last tiles that other ranks do not take: reading their bricks would cost more than it saves.
  static constexpr std::uint32_t kSpared = 4;
  std::vector<PixelRect> tiles;       // fill the crop, in pixels of the whole picture; consecutive tiles are neighbours
  std::vector<std::uint32_t> bounds;  // the i-th rank's tiles are [bounds[i], bounds[i + 1])
  std::vector<BrickHome> homes;       // bricks in view, each at the rank whose tiles show most of the brick
  bool wholeFrames() const { return tiles.empty(); }  // whole frames are handed out instead of tiles
};

/// Plans one rectangle per rank with about an even share of the work, as rows, columns or blocks: the layout with the
/// fewest bytes to read over the frames. `kAuto` hands out whole frames if there are enough frames and tiles would read
/// as much, or be too few to share. requires: frames of one volume, `frames` not empty, not `kFrames`.
TilePlan planTiles(OpenedJob& opened, const std::vector<int>& frames, int ranks, Distribution distribution);

}  // namespace kiln
