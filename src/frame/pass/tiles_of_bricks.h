// Shares the work of bricks out among threads: tiles of the picture, each with its bricks.
// Method. The largest square that is left becomes a tile if it is a small part of what is left, else its quarters are
// left. Large tiles, which some engines draw in less time, thus come first, and small tiles last: all threads end
// together.
// Source: guided self-scheduling, Polychronopoulos and Kuck 1987.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/pixel_rect.h"

namespace kiln {

/// A tile of the picture, or several neighbours, and its bricks.
struct TileOfBricks {
  PixelRect rect;
  std::vector<std::size_t> bricks;  // places among all bricks, ascending
  std::uint64_t pixels = 0;         // pixels that bricks may touch, summed over bricks: an estimate of the work
};

/// Largest edge of joined tiles: a frame is cancelled and reports its progress between tiles, and larger squares take
/// no less time. unit: pixels.
inline constexpr int kMostJoined_px = 512;

/// Returns tiles that together hold the pixels of all bricks in `drawn`, in the order in which threads begin them.
/// Borders of tiles inside `drawn` are multiples of `tile_px`; with a `tile_px` of 0, `drawn` is the tile. A tile of
/// more than `tile_px` pixels an edge has at most kMostJoined_px, and at most one of `parts` equal parts of the work
/// not begun before. `rects`: the pixels that each brick may touch.
std::vector<TileOfBricks> tilesOfBricks(std::span<const PixelRect> rects, const PixelRect& drawn, int tile_px,
                                        std::uint64_t parts);

}  // namespace kiln
