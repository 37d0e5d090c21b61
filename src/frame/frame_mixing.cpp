// The part of a frame's drawing that is its own where several volumes are in one picture: zone after zone, as many
// tiles at once as the cache has room for the bricks of.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "base/memory/memory.h"
#include "base/thread/profile_scope.h"
#include "frame/frame_drawing.h"

namespace kiln {

void FrameDrawing::mix(const TilePixels& all) {
  walked_.bricks = plan_.mix->counts().bricks;
  walked_.interesting = plan_.mix->counts().interesting;
  const std::vector<PixelRect> tiles = tilesOf(all.rect, all.rect);
  part_.emplace(progress_, "tiles", plan_.stepsOf(all.rect, request_.tile_px));
  mixed_steps_ = 0;
  for (std::size_t zone = 0; zone < plan_.mix->zones(); ++zone) {
    std::vector<PixelRect> open, hidden;
    for (const PixelRect& tile : tiles) (visibility_->hidden(tile) ? hidden : open).push_back(tile);
    if (open.empty()) break;  // and so they stay
    mixed_steps_ += plan_.stepsOf(zone, hidden);
    mixTiles(zone, all, open);
  }
  std::uint64_t unseen = 0;
  for (const StoredBrick& brick : plan_.mix->inView(all.rect)) unseen += mixed_.contains(brick) ? 0 : 1;
  walked_.hidden += unseen;
}

std::vector<const MultiVolume::Brick*> FrameDrawing::toBeMixed(std::size_t zone,
                                                               std::span<const PixelRect> tiles) const {
  std::vector<const MultiVolume::Brick*> out;
  for (const MultiVolume::Brick& brick : plan_.mix->bricksOf(zone)) {
    const bool seen = std::any_of(tiles.begin(), tiles.end(), [&](const PixelRect& tile) {
      const PixelRect touched = intersection(tile, brick.rect);
      return !touched.empty() && !visibility_->hidden(touched);
    });
    if (seen) out.push_back(&brick);
  }
  return out;
}

void FrameDrawing::mixTiles(std::size_t zone, const TilePixels& all, std::span<const PixelRect> tiles) {
  progress_.throwIfCancelled("rendering");
  part_->reached(mixed_steps_);
  const std::vector<const MultiVolume::Brick*> bricks = toBeMixed(zone, tiles);
  if (bricks.empty()) {
    mixed_steps_ += plan_.stepsOf(zone, tiles);
    return;
  }
  const std::uint64_t needed = plan_.mix->bytesFor(bricks), room = cache_.budgetBytes();
  if (needed > room && tiles.size() > 1) {
    mixTiles(zone, all, tiles.first(tiles.size() / 2));
    mixTiles(zone, all, tiles.subspan(tiles.size() / 2));
    return;
  }
  if (needed > room)
    throw Error(ErrorCode::kBudget, store_.path(), "--memory",
                fmt::format("is too little: bricks have {} of it, and those of the volumes that meet in one tile take "
                            "{} at once; give {} more",
                            formatBytes(room), formatBytes(needed), roundedUpBytes(needed - room)));
  announce(bricks);
  MultiVolume::Blocks blocks;
  for (const MultiVolume::Brick* const brick : bricks) {
    const StoredBrick& key = brick->brick;
    blocks.push_back(cache_.get(key));
    if (!blocks.back()) statistics_.damaged.insert(key);
    const bool first = mixed_.insert(key).second;
    if (first && blocks.back()) ++statistics_.levels[static_cast<std::size_t>(key.key.level)].bricks;
  }
  announceBehind(zone, tiles);
  drawMixed(zone, bricks, blocks, all, tiles);
}

void FrameDrawing::drawMixed(std::size_t zone, std::span<const MultiVolume::Brick* const> bricks,
                             const MultiVolume::Blocks& blocks, const TilePixels& all,
                             std::span<const PixelRect> tiles) {
  const ProfileScope drawing(Activity::kBrick);
  std::vector<TilePixels> pixels;
  for (const PixelRect& tile : tiles) pixels.push_back(all.of(tile));
  const std::uint64_t steps = plan_.stepsOf(zone, tiles);
  std::atomic<std::uint64_t> so_far = 0;
  const auto tile_drawn = [&](std::size_t tile) {
    const std::uint64_t of_tile = plan_.mix->bricksIn(zone, tiles[tile]);
    part_->within(steps, so_far += of_tile, steps);
  };
  const std::vector<DrawCounts> drawn =
      plan_.mix->draw(zone, bricks, blocks, pixels, *visibility_, frame_.opaque_at, tile_drawn);
  mixed_steps_ += steps;
  for (std::size_t v = 0; v < drawn.size(); ++v) {
    counts_.add(drawn[v]);
    if (const auto level = plan_.mix->levelOf(zone, v)) {
      LevelStatistics& statistics = statistics_.levels[static_cast<std::size_t>(*level)];
      statistics.voxels_visited += drawn[v].visited;
      statistics.voxels_splats += drawn[v].splats;
    }
  }
}

void FrameDrawing::announce(std::span<const MultiVolume::Brick* const> bricks) {
  std::vector<NextBrick> next;
  for (const MultiVolume::Brick* const brick : bricks) next.push_back({brick->brick});
  cache_.announce(next);
}

// While a zone is drawn, what the next one will need is read.
void FrameDrawing::announceBehind(std::size_t zone, std::span<const PixelRect> tiles) {
  if (cache_.readsAhead() && zone + 1 < plan_.mix->zones()) announce(toBeMixed(zone + 1, tiles));
}

}  // namespace kiln
