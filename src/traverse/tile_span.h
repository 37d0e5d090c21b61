// What a brick shows in a tile, as a span that tells what was drawn.
#pragma once

#include "base/thread/span.h"
#include "engine/shared/draw_counts.h"
#include "grid/coords.h"
#include "image/pixel_rect.h"

namespace kiln {

class TileSpan {
 public:
  /// requires: `tile` and `counts`, which drawing adds to, outlive this.
  TileSpan(const BrickKey& brick, const PixelRect& tile, const DrawCounts& counts) noexcept
      : brick_(brick), tile_(tile), counts_(counts), before_(counts) {}
  ~TileSpan();
  TileSpan(const TileSpan&) = delete;
  TileSpan& operator=(const TileSpan&) = delete;

 private:
  const BrickKey brick_;
  const PixelRect& tile_;
  const DrawCounts& counts_;
  const DrawCounts before_;
  Span span_{Activity::kTile};
};

}  // namespace kiln
