// How ranks share the pixels of a job: a frame's tiles, and which of them each rank draws first, frame after frame, so
// that the bricks behind its tiles stay in its memory. Planned by the index alone, as if nothing were hidden.
#pragma once

#include <cstdint>
#include <vector>

#include "image/pixel_rect.h"
#include "sequence/opened_job.h"

namespace kiln {

struct TilePlan {
  /// Of its tiles, how many others leave to a rank: to take them would make them read its bricks, for little time.
  static constexpr std::uint32_t kSpared = 4;
  std::vector<PixelRect> tiles;       // of the whole picture's pixels; they fill the crop, neighbours behind each other
  std::vector<std::uint32_t> bounds;  // the i-th rank's tiles are [bounds[i], bounds[i + 1])
  std::vector<BrickHome> homes;       // bricks that are seen, each at the rank whose tiles have most of it
  bool wholeFrames() const { return tiles.empty(); }  // are handed out, not their tiles
};

/// The tiles of a rank lie in one rectangle of about an even share of the work: in rows, in columns or in blocks,
/// whichever reads the fewest bytes over the frames. `kAuto` takes whole frames where there are enough of them and
/// tiles would read as much, or be too few to share. requires: frames of one volume, `frames` not empty.
TilePlan planTiles(OpenedJob& opened, const std::vector<int>& frames, int ranks, Distribution distribution);

}  // namespace kiln
