#include "occlusion/alpha_quadtree.h"

#include <atomic>

namespace kiln {
namespace {

// Returns the squares along an axis of the next level.
int halved(int squares) { return (squares + 1) / 2; }

}  // namespace

std::uint64_t quadtreeBytes(int width, int height) {
  const auto squares = [&] { return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height); };
  std::uint64_t out = squares();
  while (width > 1 || height > 1) {
    width = halved(width), height = halved(height);
    out += squares();
  }
  return out;
}

AlphaQuadtree::AlphaQuadtree(int width, int height) {
  levels_.push_back({width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height)});
  while (levels_.back().columns > 1 || levels_.back().rows > 1) {
    const int fine_columns = levels_.back().columns;
    const int fine_rows = levels_.back().rows;
    Level coarse{halved(fine_columns), halved(fine_rows), {}};
    coarse.counts.resize(static_cast<std::size_t>(coarse.columns) * coarse.rows);
    // Quarters outside the image count as opaque from the start.
    for (int y = 0; y < coarse.rows; ++y) {
      for (int x = 0; x < coarse.columns; ++x) {
        const int across = std::min(fine_columns - 2 * x, 2);
        const int down = std::min(fine_rows - 2 * y, 2);
        coarse.counts[static_cast<std::size_t>(y) * coarse.columns + x] =
            static_cast<std::uint8_t>(kOpaque - across * down);
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

void AlphaQuadtree::close(int x, int y) {
  levels_[0].counts[static_cast<std::size_t>(y) * levels_[0].columns + x] = kOpaque;
  for (int k = 1; k <= top(); ++k) {
    x >>= 1;
    y >>= 1;
    Level& squares = levels_[static_cast<std::size_t>(k)];
    std::uint8_t& count = squares.counts[static_cast<std::size_t>(y) * squares.columns + x];
    const int now = k > kVisibilityTileLevel ? std::atomic_ref(count).fetch_add(1) + 1 : ++count;
    if (now != kOpaque) return;
  }
}

SquareBounds squareBoundsOf(const PixelRect& rect, int tile_px, const PixelRect& image) {
  if (tile_px == 0) return {image, false};
  const int x = rect.x0 / tile_px * tile_px;
  const int y = rect.y0 / tile_px * tile_px;
  if (rect.x1 > x + tile_px || rect.y1 > y + tile_px) return {image, false};
  return {{x, y, x + tile_px, y + tile_px}, true};
}

}  // namespace kiln
