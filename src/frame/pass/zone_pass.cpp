#include "frame/pass/zone_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "frame/pass/frame_progress.h"

namespace kiln {

// Draws one piece of the picture.
class ZonePass::Drawing {
 public:
  Drawing(ZonePass& pass, const PassTarget& target, PassContext& context)
      : pass_(pass),
        volumes_(pass.volumes_),
        target_(target),
        context_(context),
        part_(context.progress, "tiles", pass.steps(target.pixels.rect)) {}

  void run() {
    BrickWalkCounts& walked = context_.costs.walked;
    walked.bricks = volumes_.counts().bricks;
    walked.interesting = volumes_.counts().interesting;
    walked.masked = volumes_.counts().masked;
    const PixelRect& pixels = target_.pixels.rect;
    const std::vector<PixelRect> tiles = tilesOf(pass_.tile_px_, pixels, pixels);
    for (std::size_t zone = 0; zone < volumes_.zones(); ++zone) {
      std::vector<PixelRect> open, hidden;
      for (const PixelRect& tile : tiles) (target_.visibility.hidden(tile) ? hidden : open).push_back(tile);
      if (open.empty()) break;  // tiles stay hidden
      steps_ += pass_.steps(zone, hidden);
      drawZone(zone, open);
    }
    for (const StoredBrick& brick : volumes_.inView(pixels)) walked.hidden += pass_.drawn_.contains(brick) ? 0 : 1;
    part_.finish();
  }

 private:
  using Bricks = std::vector<const MultiVolume::Brick*>;
  struct TileCosts {
    DrawCounts drawn;
    std::vector<LevelStatistics> levels;
    std::vector<StoredBrick> changed;  // bricks that changed a pixel
  };

  Bricks visibleBricks(std::size_t zone, std::span<const PixelRect> tiles) const {
    Bricks out;
    for (const MultiVolume::Brick& brick : volumes_.bricksOf(zone)) {
      const bool seen = std::any_of(tiles.begin(), tiles.end(), [&](const PixelRect& tile) {
        const PixelRect touched = intersection(tile, brick.rect);
        return !touched.empty() && !target_.visibility.hidden(touched);
      });
      if (seen) out.push_back(&brick);
    }
    return out;
  }

  // Draws the tiles of a zone, in two halves if their bricks do not fit into the cache.
  void drawZone(std::size_t zone, std::span<const PixelRect> tiles) {
    context_.progress.throwIfCancelled("rendering");
    part_.reached(steps_);
    const Bricks bricks = visibleBricks(zone, tiles);
    if (bricks.empty()) {
      steps_ += pass_.steps(zone, tiles);
      return;
    }
    const std::uint64_t needed = volumes_.bytesFor(bricks), room = context_.cache.bricksBytes();
    if (needed > room && tiles.size() > 1) {
      drawZone(zone, tiles.first(tiles.size() / 2));
      drawZone(zone, tiles.subspan(tiles.size() / 2));
      return;
    }
    if (needed > room)
      throw Error(
          ErrorCode::kBudget, context_.cache.stores().front()->path(), "--memory",
          fmt::format("is too little: bricks have {} of it, and those of the volumes that meet in one tile take "
                      "{} at once; give {} more",
                      formatBytes(room), formatBytes(needed), roundedUpBytes(needed - room)));
    const BrickCache::Aside cells(context_.cache, MultiVolume::cellBytesFor(bricks));
    announce(bricks);
    const std::vector<BrickToDraw> read = readBricks(bricks);
    // The next zone is read while this zone is drawn.
    if (context_.cache.readsAhead() && zone + 1 < volumes_.zones()) announce(visibleBricks(zone + 1, tiles));
    drawTiles(zone, read, tiles);
  }

  void announce(const Bricks& bricks) {
    std::vector<NextBrick> next;
    for (const MultiVolume::Brick* const brick : bricks) next.push_back({brick->brick});
    context_.cache.announce(next);
  }

  // Returns the readable bricks.
  std::vector<BrickToDraw> readBricks(const Bricks& bricks) {
    FrameStatistics& statistics = context_.costs.statistics;
    std::vector<BrickToDraw> out;
    for (const MultiVolume::Brick* const brick : bricks) {
      context_.progress.throwIfCancelled("rendering");
      const StoredBrick& key = brick->brick;
      std::shared_ptr<const BrickBlock> block = context_.cache.get(key);
      const bool first = pass_.drawn_.insert(key).second;
      if (!block) {
        statistics.damaged.insert(key);
        continue;
      }
      if (first) ++statistics.levels[static_cast<std::size_t>(key.key.level)].bricks;
      out.push_back({key, brick->rect, std::move(block)});
    }
    return out;
  }

  void drawTiles(std::size_t zone, const std::vector<BrickToDraw>& bricks, std::span<const PixelRect> tiles) {
    const ProfileScope drawing(Activity::kBrick);
    Engine& engine = volumes_.engine(zone);
    std::vector<std::unique_ptr<const PreparedBrick>> prepared(bricks.size());
    parallelFor(bricks.size(), [&](std::size_t i) { prepared[i] = engine.prepare(bricks[i]); });
    const std::uint64_t steps = pass_.steps(zone, tiles);
    std::atomic<std::uint64_t> so_far = 0;
    std::vector<TileCosts> costs(tiles.size());
    parallelFor(tiles.size(), [&](std::size_t t) {
      const ProfileScope span(Activity::kTile);
      costs[t] = drawTile(engine, bricks, prepared, tiles[t]);
      part_.within(steps, so_far += volumes_.bricksIn(zone, tiles[t]), steps);
    });
    steps_ += steps;
    for (const TileCosts& tile : costs) add(tile);
  }

  void add(const TileCosts& tile) {
    FrameStatistics& statistics = context_.costs.statistics;
    context_.costs.drawn.add(tile.drawn);
    for (std::size_t level = 0; level < tile.levels.size(); ++level) {
      statistics.levels[level].voxels_visited += tile.levels[level].voxels_visited;
      statistics.levels[level].voxels_splats += tile.levels[level].voxels_splats;
    }
    for (const StoredBrick& brick : tile.changed) {
      const BrickedVolume& store = *context_.cache.stores()[static_cast<std::size_t>(brick.store)];
      statistics.addContributing(brick, store.index().at(brick.key).file_bytes);
    }
  }

  TileCosts drawTile(Engine& engine, const std::vector<BrickToDraw>& bricks,
                     const std::vector<std::unique_ptr<const PreparedBrick>>& prepared, const PixelRect& tile) const {
    std::vector<const PreparedBrick*> touching;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      if (intersection(bricks[i].rect, tile).empty()) continue;
      touching.push_back(prepared[i].get());
      places.push_back(i);
    }
    std::vector<DrawCounts> counts(touching.size());
    engine.draw(touching, {target_.pixels.of(tile), target_.visibility, target_.opacity_threshold, counts});
    TileCosts out;
    out.levels.resize(context_.costs.statistics.levels.size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const StoredBrick& brick = bricks[places[i]].brick;
      out.drawn.add(counts[i]);
      LevelStatistics& level = out.levels[static_cast<std::size_t>(brick.key.level)];
      level.voxels_visited += counts[i].visited;
      level.voxels_splats += counts[i].splats;
      if (counts[i].changed) out.changed.push_back(brick);
    }
    return out;
  }

  ZonePass& pass_;
  MultiVolume& volumes_;
  const PassTarget& target_;
  PassContext& context_;
  PartProgress part_;
  std::uint64_t steps_ = 0;
};

ZonePass::ZonePass(std::vector<MixedVolume> volumes, const MixView& view, int tile_px)
    : volumes_(std::move(volumes), view), tile_px_(tile_px) {}

std::vector<BrickOfFrame> ZonePass::inView(const PixelRect& pixels, BrickWalkCounts& counts) const {
  counts = volumes_.counts();
  std::vector<BrickOfFrame> out;
  for (const StoredBrick& brick : volumes_.inView(pixels)) out.push_back({brick, pixels});
  return out;
}

std::uint64_t ZonePass::steps(const PixelRect& pixels) const {
  const std::vector<PixelRect> tiles = tilesOf(tile_px_, pixels, pixels);
  std::uint64_t out = 0;
  for (std::size_t zone = 0; zone < volumes_.zones(); ++zone) out += steps(zone, tiles);
  return out;
}

std::uint64_t ZonePass::steps(std::size_t zone, std::span<const PixelRect> tiles) const {
  std::uint64_t out = 0;
  for (const PixelRect& tile : tiles) out += volumes_.bricksIn(zone, tile);
  return out;
}

PixelRect ZonePass::draw(const PassTarget& target, PassContext& context) {
  Drawing(*this, target, context).run();
  return target.pixels.rect;
}

std::uint64_t ZonePass::bytesAtOnce(const PixelRect& pixels) const {
  return volumes_.mostBytes(tilesOf(tile_px_, pixels, pixels));
}

}  // namespace kiln
