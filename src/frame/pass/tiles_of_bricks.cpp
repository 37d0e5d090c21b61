#include "frame/pass/tiles_of_bricks.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace kiln {
namespace {

// A square of tiles, and what it holds of the picture.
struct Square {
  int x, y, edge;
  TileOfBricks tile;
};

// Ahead in a heap: squares with more work; of equal squares the upper left.
bool isBehind(const Square& a, const Square& b) {
  if (a.tile.pixels != b.tile.pixels) return a.tile.pixels < b.tile.pixels;
  return a.y != b.y ? a.y > b.y : a.x > b.x;
}

TileOfBricks tileOf(std::span<const PixelRect> rects, const PixelRect& rect) {
  TileOfBricks out{rect, {}, 0};
  for (std::size_t i = 0; i < rects.size(); ++i) {
    const PixelRect common = intersection(rects[i], rect);
    if (common.empty()) continue;
    out.bricks.push_back(i);
    out.pixels += common.count();
  }
  return out;
}

// The least square of tiles around `drawn` whose edge is a power of two tiles.
PixelRect squareAround(const PixelRect& drawn, int tile_px) {
  const PixelRect tiles{drawn.x0 / tile_px, drawn.y0 / tile_px, (drawn.x1 - 1) / tile_px + 1,
                        (drawn.y1 - 1) / tile_px + 1};
  const auto longer = static_cast<unsigned>(std::max(tiles.width(), tiles.height()));
  const int x = tile_px * tiles.x0, y = tile_px * tiles.y0, edge = tile_px * static_cast<int>(std::bit_ceil(longer));
  return {x, y, x + edge, y + edge};
}

}  // namespace

std::vector<TileOfBricks> tilesOfBricks(std::span<const PixelRect> rects, const PixelRect& drawn, int tile_px,
                                        std::uint64_t parts) {
  if (tile_px == 0) return {tileOf(rects, drawn)};
  std::vector<TileOfBricks> out;
  std::vector<Square> left;
  const auto leave = [&](int x, int y, int edge) {
    const PixelRect rect = intersection(PixelRect{x, y, x + edge, y + edge}, drawn);
    if (rect.empty()) return;
    Square square{x, y, edge, tileOf(rects, rect)};
    if (square.tile.bricks.empty()) return;
    left.push_back(std::move(square));
    std::push_heap(left.begin(), left.end(), isBehind);
  };
  const PixelRect all = squareAround(drawn, tile_px);
  leave(all.x0, all.y0, all.width());
  std::uint64_t pixels = left.empty() ? 0 : left.front().tile.pixels;
  while (!left.empty()) {
    std::pop_heap(left.begin(), left.end(), isBehind);
    Square square = std::move(left.back());
    left.pop_back();
    const bool joins = square.edge <= kMostJoined_px && square.tile.pixels <= pixels / parts;
    if (joins || square.edge == tile_px) {
      pixels -= square.tile.pixels;
      out.push_back(std::move(square.tile));
      continue;
    }
    const int half = square.edge / 2;
    for (const int dy : {0, half}) {
      for (const int dx : {0, half}) leave(square.x + dx, square.y + dy, half);
    }
  }
  return out;
}

}  // namespace kiln
