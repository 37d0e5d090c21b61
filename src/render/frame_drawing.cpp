#include "render/frame_drawing.h"

#include <chrono>

#include "base/parallel.h"
#include "frame/lookahead.h"
#include "frame/make_visibility.h"
#include "frame/tile_walk.h"

namespace kiln {
namespace {

// Bricks announced at a time: enough to keep every reader busy while one brick is drawn.
constexpr std::size_t kAnnounced = 8;

bool testsSamples(const VisibilityOptions& options) {
  return options.test_samples && options.method != VisibilityMethod::kNone &&
         options.method != VisibilityMethod::kQuadtree;
}

float gradientNoise(const ValueRange& range) {
  return range.empty() ? 0.0f : static_cast<float>(kGradientNoise * (range.hi - range.lo));
}

// Without what depends on a brick's level.
SplatFrame splatFrameOf(const FrameRequest& request, const Classifier& classifier, Visibility& visibility) {
  SplatFrame out;
  out.classifier = &classifier;
  out.opaque_at = static_cast<float>(request.opacity_threshold);
  out.visibility = &visibility;
  out.test_samples = testsSamples(request.visibility);
  return out;
}

// The tiles of the whole frame that `rect` touches, cut off at `drawn`, which `image` holds.
std::vector<TilePixels> tilesOf(Image& image, const PixelRect& drawn, const PixelRect& rect, int tile_px) {
  if (tile_px == 0) return {{drawn, image.pixel(0, 0), std::ptrdiff_t{4} * image.width}};
  std::vector<TilePixels> out;
  for (int y = rect.y0 / tile_px * tile_px; y < rect.y1; y += tile_px) {
    for (int x = rect.x0 / tile_px * tile_px; x < rect.x1; x += tile_px) {
      const PixelRect tile = intersection(PixelRect{x, y, x + tile_px, y + tile_px}, drawn);
      out.push_back({tile, image.pixel(tile.x0 - drawn.x0, tile.y0 - drawn.y0), std::ptrdiff_t{4} * image.width});
    }
  }
  return out;
}

SplatCounts drawBrick(const SplatFrame& frame, const BrickBlock& block, const std::vector<TilePixels>& tiles,
                      NodeLog* log) {
  std::vector<SplatCounts> counts(tiles.size());
  parallelFor(tiles.size(), [&](std::size_t i) { walkTile(frame, block, tiles[i], counts[i], log); });
  SplatCounts total;
  for (const SplatCounts& tile : counts) total.add(tile);
  return total;
}

double opacityUnit(const StoreReader& store, const FrameRequest& request) {
  return request.transfer_function.unitIn(store.level(0).geometry.meanSpacing());
}

Classifier classifierFor(const StoreReader& store, const FrameRequest& request) {
  return Classifier(request.transfer_function, opacityUnit(store, request), store.manifest().type,
                    store.manifest().range);
}

}  // namespace

FramePlan::FramePlan(const StoreReader& store, const FrameRequest& request)
    : levels(store.manifest(), request.level, request.view, request.visibility.area, request.clipping),
      classifier(classifierFor(store, request)) {
  if (request.lattice == Lattice::kPixel) {
    pixel.emplace(store.manifest(), levels, request.view, request.level, request.interpolation,
                  request.transfer_function, request.shading, gradientNoise(store.manifest().range), request.sweep_px);
    bricks.emplace(store, levels, pixel->choice(), pixel->interesting(), kMostGhosts);
  } else {
    bricks.emplace(store, levels, voxelChoice(levels), showsCore(classifier));
  }
}

FrameDrawing::FrameDrawing(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress)
    : store_(store),
      cache_(cache),
      request_(request),
      progress_(progress),
      plan_(store, request),
      visibility_(makeVisibility(request.visibility, request.view.size, request.tile_px)),
      frame_(splatFrameOf(request, plan_.classifier, *visibility_)),
      before_(cache.counts()) {
  statistics_.levels.assign(store.manifest().levels.size(), {});
}

Image FrameDrawing::draw(const PixelRect& pixels) {
  Image image(pixels.width(), pixels.height());
  std::optional<Lookahead> lookahead;
  if (cache_.readsAhead()) {
    BrickWalkCounts ignored;
    lookahead.emplace(plan_.bricks->inView(pixels, ignored), *visibility_);
  }
  const auto draw = [&](const BrickKey& key, const PixelRect& rect) {
    progress_.throwIfCancelled("rendering");
    const std::shared_ptr<const BrickBlock> block = cache_.get(key);
    if (lookahead) cache_.announce(lookahead->after(key, kAnnounced));
    if (block)
      drawBlock(*block, tilesOf(image, pixels, rect, request_.tile_px));
    else
      damaged_.insert(key);
  };
  plan_.bricks->run(pixels, *visibility_, draw, walked_, request_.node_log);
  return image;
}

void FrameDrawing::drawBlock(const BrickBlock& block, const std::vector<TilePixels>& tiles) {
  const int level = block.key.level;
  const SplatCounts drawn = plan_.pixel
                                ? plan_.pixel->draw(block, tiles, *visibility_, frame_.test_samples, frame_.opaque_at)
                                : drawBrick(frameOfLevel(level), block, tiles, request_.node_log);
  counts_.add(drawn);
  statistics_.levels[static_cast<std::size_t>(level)].add(drawn.visited, drawn.splats);
  if (drawn.changed && contributing_.insert(block.key).second)
    statistics_.addContributing(store_.index().at(block.key).file_bytes);
}

SplatFrame FrameDrawing::frameOfLevel(int level) const {
  SplatFrame out = frame_;
  out.projector = &plan_.levels.projector(level);
  out.shader = Shader(request_.shading, request_.view, gradientNoise(store_.manifest().range), *out.projector);
  out.gradient_opacity = GradientOpacity(request_.transfer_function, opacityUnit(store_, request_), *out.projector);
  out.clip = &plan_.levels.clipRegion(level);
  out.ends = plan_.levels.endVoxels(level);
  return out;
}

FrameStatistics FrameDrawing::finish() {
  cache_.settle();
  const CacheCounts after = cache_.counts();
  FrameStatistics out = statistics_;
  out.voxels_visited = counts_.visited;
  out.voxels_splats = counts_.splats;
  out.nodes_tested = counts_.nodes_tested + walked_.nodes_tested;
  out.nodes_hidden = counts_.nodes_hidden + walked_.nodes_hidden;
  out.bricks_total = walked_.bricks;
  out.bricks_interesting = walked_.interesting;
  out.bricks_hidden = walked_.hidden;
  out.bricks_read = after.reads - before_.reads;
  out.bricks_unused = after.unused - before_.unused;
  out.bricks_damaged = damaged_.size();
  out.bricks_read_bytes = after.read_bytes - before_.read_bytes;
  out.slab_bytes = plan_.pixel ? plan_.pixel->bytes() : 0;
  out.load_s = after.load_seconds - before_.load_seconds;
  return out;
}

}  // namespace kiln
