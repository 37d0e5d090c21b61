// Profile scope of a brick's drawing in a tile, with the counts of that drawing.
#pragma once

#include "base/thread/profile_scope.h"
#include "engine/shared/draw_counts.h"
#include "grid/coords.h"
#include "image/pixel_rect.h"

namespace kiln {

class TileScope {
 public:
  /// requires: `tile` and `counts` outlive the scope; drawing adds to `counts`.
  TileScope(const BrickKey& brick, const PixelRect& tile, const DrawCounts& counts) noexcept
      : brick_(brick), tile_(tile), counts_(counts), before_(counts) {}
  ~TileScope();
  TileScope(const TileScope&) = delete;
  TileScope& operator=(const TileScope&) = delete;

 private:
  const BrickKey brick_;
  const PixelRect& tile_;
  const DrawCounts& counts_;
  const DrawCounts before_;
  ProfileScope span_{Activity::kTile};
};

}  // namespace kiln
