// What a brick shows in a tile, as a span that tells what was drawn.
#pragma once

#include "base/span.h"
#include "splat/splat_cell.h"

namespace kiln {

class TileSpan {
 public:
  /// requires: `tile` and `counts`, which drawing adds to, outlive this.
  TileSpan(const BrickKey& brick, const PixelRect& tile, const SplatCounts& counts) noexcept
      : brick_(brick), tile_(tile), counts_(counts), before_(counts) {}
  ~TileSpan();
  TileSpan(const TileSpan&) = delete;
  TileSpan& operator=(const TileSpan&) = delete;

 private:
  const BrickKey brick_;
  const PixelRect& tile_;
  const SplatCounts& counts_;
  const SplatCounts before_;
  Span span_{Activity::kTile};
};

}  // namespace kiln
