#include "render/render_frame.h"

#include <fmt/format.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <optional>
#include <vector>

#include "base/parallel.h"
#include "frame/brick_walk.h"
#include "frame/lookahead.h"
#include "frame/make_visibility.h"
#include "frame/pixel_lattice.h"
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

std::vector<TilePixels> tilesOf(Image& image, const PixelRect& rect, int tile_px) {
  if (tile_px == 0) return {{{0, 0, image.width, image.height}, image.pixel(0, 0), std::ptrdiff_t{4} * image.width}};
  std::vector<TilePixels> out;
  for (int y = rect.y0 / tile_px * tile_px; y < rect.y1; y += tile_px) {
    for (int x = rect.x0 / tile_px * tile_px; x < rect.x1; x += tile_px) {
      const PixelRect tile =
          intersection(PixelRect{x, y, x + tile_px, y + tile_px}, PixelRect{0, 0, image.width, image.height});
      out.push_back({tile, image.pixel(tile.x0, tile.y0), std::ptrdiff_t{4} * image.width});
    }
  }
  return out;
}

SplatCounts drawBrick(const SplatFrame& frame, const BrickBlock& block, Image& image, const PixelRect& rect,
                      const FrameRequest& request) {
  const std::vector<TilePixels> tiles = tilesOf(image, rect, request.tile_px);
  std::vector<SplatCounts> counts(tiles.size());
  parallelFor(tiles.size(), [&](std::size_t i) { walkTile(frame, block, tiles[i], counts[i], request.node_log); });
  SplatCounts total;
  for (const SplatCounts& tile : counts) total.add(tile);
  return total;
}

void layOverBackground(Image& image, const Background& background) {
  if (background == Background{}) return;
  for (int y = 0; y < image.height; ++y) {
    // From the middle of the first row to that of the last.
    const double t = image.height > 1 ? static_cast<double>(y) / (image.height - 1) : 0;
    float row[4];
    for (std::size_t channel = 0; channel < 4; ++channel)
      row[channel] = static_cast<float>(std::lerp(background.top[channel], background.bottom[channel], t));
    for (int x = 0; x < image.width; ++x) {
      float* pixel = image.pixel(x, y);
      const float open = 1.0f - pixel[3];
      for (int channel = 0; channel < 4; ++channel) pixel[channel] += open * row[channel];
    }
  }
}

void requireRequest(const StoreReader& store, const FrameRequest& request) {
  const int levels = store.index().levels();
  if (request.level && (*request.level < 0 || *request.level >= levels)) {
    throw Error(ErrorCode::kUsage, fmt::format("--level: there is no level {}; {} has {}, from 0 to {}", *request.level,
                                               store.path().string(),
                                               levels == 1 ? "1 level" : fmt::format("{} levels", levels), levels - 1));
  }
  const int tile_px = request.tile_px;
  if (tile_px != 0 && (tile_px < kVisibilityTile || !std::has_single_bit(static_cast<unsigned>(tile_px)))) {
    throw Error(ErrorCode::kUsage, fmt::format("a tile of {} pixels: expected a power of two from {} on, or 0 for the "
                                               "whole frame",
                                               tile_px, kVisibilityTile));
  }
}

double opacityUnit(const StoreReader& store, const FrameRequest& request) {
  return request.transfer_function.unit > 0 ? request.transfer_function.unit : store.level(0).geometry.meanSpacing();
}

Classifier classifierFor(const StoreReader& store, const FrameRequest& request) {
  return Classifier(request.transfer_function, opacityUnit(store, request), store.manifest().type,
                    store.manifest().range);
}

// What of the volume a frame asks for, before any of it is read.
struct FramePlan {
  FramePlan(const StoreReader& store, const FrameRequest& request)
      : levels(store.manifest(), request.level, request.view, request.visibility.area, request.clipping),
        classifier(classifierFor(store, request)) {
    if (request.lattice == Lattice::kPixel) {
      pixel.emplace(store.manifest(), levels, request.view, request.level, request.transfer_function, request.shading,
                    gradientNoise(store.manifest().range), request.sweep_px);
      bricks.emplace(store, levels, pixel->choice(), pixel->interesting(), kMostGhosts);
    } else {
      bricks.emplace(store, levels, voxelChoice(levels), showsCore(classifier));
    }
  }
  FramePlan(const FramePlan&) = delete;
  FramePlan& operator=(const FramePlan&) = delete;

  FrameLevels levels;
  Classifier classifier;
  std::optional<PixelLattice> pixel;  // else the voxel lattice
  std::optional<BrickWalk> bricks;
};

}  // namespace

std::vector<BrickInView> bricksInView(const StoreReader& store, const FrameRequest& request, BrickWalkCounts& counts) {
  requireRequest(store, request);
  return FramePlan(store, request).bricks->inView({0, 0, request.view.size.width, request.view.size.height}, counts);
}

Image renderFrame(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress,
                  FrameStatistics& statistics) {
  const auto begin = std::chrono::steady_clock::now();
  requireRequest(store, request);
  const Manifest& manifest = store.manifest();
  const CacheCounts before = cache.counts();

  FramePlan plan(store, request);
  std::optional<PixelLattice>& pixel = plan.pixel;
  const std::unique_ptr<Visibility> visibility = makeVisibility(request.visibility, request.view.size, request.tile_px);
  Image image(request.view.size.width, request.view.size.height);
  SplatFrame frame = splatFrameOf(request, plan.classifier, *visibility);
  SplatCounts counts;
  statistics = {};
  statistics.levels.assign(manifest.levels.size(), {});
  BrickWalkCounts walked;
  const PixelRect whole{0, 0, image.width, image.height};
  std::optional<Lookahead> lookahead;
  if (cache.readsAhead()) {
    BrickWalkCounts ignored;
    lookahead.emplace(plan.bricks->inView(whole, ignored), *visibility);
  }
  const auto draw = [&](const BrickKey& key, const PixelRect& rect) {
    progress.throwIfCancelled("rendering");
    const std::shared_ptr<const BrickBlock> block = cache.get(key);
    if (lookahead) cache.announce(lookahead->after(key, kAnnounced));
    if (!block) return;
    frame.projector = &plan.levels.projector(key.level);
    frame.shader = Shader(request.shading, request.view, gradientNoise(manifest.range), *frame.projector);
    frame.gradient_opacity = GradientOpacity(request.transfer_function, opacityUnit(store, request), *frame.projector);
    frame.clip = &plan.levels.clipRegion(key.level);
    frame.ends = plan.levels.endVoxels(key.level);
    const SplatCounts drawn = pixel ? pixel->draw(*block, tilesOf(image, rect, request.tile_px), *visibility,
                                                  frame.test_samples, frame.opaque_at)
                                    : drawBrick(frame, *block, image, rect, request);
    counts.add(drawn);
    statistics.levels[static_cast<std::size_t>(key.level)].add(drawn.visited, drawn.splats);
    if (drawn.changed) statistics.addContributing(store.index().at(key).file_bytes);
  };
  plan.bricks->run(whole, *visibility, draw, walked, request.node_log);
  cache.settle();
  layOverBackground(image, request.background);

  const CacheCounts after = cache.counts();
  statistics.voxels_visited = counts.visited;
  statistics.voxels_splats = counts.splats;
  statistics.nodes_tested = counts.nodes_tested + walked.nodes_tested;
  statistics.nodes_hidden = counts.nodes_hidden + walked.nodes_hidden;
  statistics.bricks_total = walked.bricks;
  statistics.bricks_interesting = walked.interesting;
  statistics.bricks_hidden = walked.hidden;
  statistics.bricks_read = after.reads - before.reads;
  statistics.bricks_unused = after.unused - before.unused;
  statistics.bricks_damaged = after.skipped - before.skipped;
  statistics.bricks_read_bytes = after.read_bytes - before.read_bytes;
  statistics.slab_bytes = pixel ? pixel->bytes() : 0;
  statistics.load_s = after.load_seconds - before.load_seconds;
  statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return image;
}

}  // namespace kiln
