#include "frame/frame_drawing.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <utility>

#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "engine/voxel/tile_walk.h"
#include "frame/aov_planes.h"
#include "frame/make_visibility.h"
#include "traverse/tile_scope.h"

namespace kiln {
namespace {

// Where values are projected, pixels know what they hold themselves.
VisibilityOptions visibilityOf(const FrameRequest& request) {
  VisibilityOptions out = request.visibility;
  if (request.mode != Mode::kComposite) out.method = VisibilityMethod::kNone;
  return out;
}

// What the quadtree draws is to be what its own answers leave.
bool testsSamples(const VisibilityOptions& options) {
  return options.test_samples && options.method != VisibilityMethod::kNone &&
         options.method != VisibilityMethod::kQuadtree;
}

// Without what depends on a brick's level, and on what is drawn already.
SplatContext splatFrameOf(const FrameRequest& request, const Classifier& classifier) {
  SplatContext out;
  out.classifier = &classifier;
  // Above zero among floats, too: a pixel without opacity is not closed.
  out.opaque_at = std::max(static_cast<float>(request.opacity_threshold), 1e-30f);
  out.test_samples = testsSamples(request.visibility);
  return out;
}

// One thread gains nothing by several bricks at a time, and its statistics repeat; what is drawn sequentially is to be
// asked about in its order; and the quadtree's answers are as wrong as their time has it.
std::size_t drawnTogether(const FrameRequest& request) {
  const bool in_turn =
      ThreadLimit::active() == 1 || request.tile_px == 0 || request.visibility.method == VisibilityMethod::kQuadtree;
  return in_turn ? 1 : static_cast<std::size_t>(request.bricks_together);
}

double opacityUnit(const StoreReader& store, const FrameRequest& request) {
  return request.transfer_function.unitIn(store.level(0).geometry.meanSpacing());
}

// Only bricks of the part that is drawn have anything.
BrickWalk::VisiblePart inPart(const FrameLevels& levels, BrickWalk::VisiblePart any_part) {
  return [&levels, any_part = std::move(any_part)](int level, const VoxelBox& core, const BrickEntry& entry,
                                                   const BrickWalk::RectTest& test) {
    return levels.clipRegion(level).part().touches(core) && any_part(level, core, entry, test);
  };
}

Image emptyImage(const PixelRect& pixels, const Aovs& aovs) {
  const ProfileScope span(Activity::kPlan);
  Image out(pixels.width(), pixels.height());
  addAovPlanes(aovs, out);
  return out;
}

std::vector<MixedVolume> mixedVolumes(const std::vector<const StoreReader*>& stores, const FrameRequest& request) {
  std::vector<MixedVolume> out;
  for (std::size_t i = 0; i < request.volumes.size(); ++i) {
    const VolumeRequest& volume = request.volumes[i];
    out.push_back({stores.at(i), volume.transfer_function, volume.shading, volume.clipping});
  }
  return out;
}

Classifier classifierFor(const StoreReader& store, const FrameRequest& request) {
  const bool several = !request.volumes.empty();
  return Classifier(several ? request.volumes.front().transfer_function : request.transfer_function,
                    opacityUnit(store, request), store.manifest().type, store.manifest().range);
}

}  // namespace

FramePlan::FramePlan(const std::vector<const StoreReader*>& stores, const FrameRequest& request)
    : levels(stores.front()->manifest(), request.level, request.view, request.visibility.area, request.clipping),
      classifier(classifierFor(*stores.front(), request)) {
  const ProfileScope span(Activity::kPlan);
  const StoreReader& store = *stores.front();
  if (!request.volumes.empty()) {
    mix.emplace(mixedVolumes(stores, request), MixView{request.view, request.visibility.area, request.sampling()});
  } else if (request.mode != Mode::kComposite) {
    projection.emplace(store, levels, request.view, request.level, request.mode,
                       request.visibility.method != VisibilityMethod::kNone);
    bricks.emplace(store, levels, projection->choice(), projection->anyPart(), ValueProjection::kGhosts);
  } else if (request.lattice != Lattice::kVoxel) {
    pixel.emplace(store.manifest(), levels, request.view, request.sampling(), request.transfer_function,
                  request.shading, gradientNoiseOf(store.manifest(), request.transfer_function));
    bricks.emplace(store, levels, pixel->choice(), inPart(levels, pixel->anyPart()), kCutGhosts);
  } else {
    bricks.emplace(store, levels, voxelChoice(levels), inPart(levels, wholeBrick(classifier)));
  }
}

std::uint64_t FramePlan::stepsOf(const PixelRect& pixels, int tile_px) const {
  if (!mix) {
    BrickWalkCounts ignored;
    return bricks->inView(pixels, ignored).size();
  }
  const std::vector<PixelRect> tiles = tilesOf(tile_px, pixels, pixels);
  std::uint64_t out = 0;
  for (std::size_t zone = 0; zone < mix->zones(); ++zone) out += stepsOf(zone, tiles);
  return out;
}

std::uint64_t FramePlan::stepsOf(std::size_t zone, std::span<const PixelRect> tiles) const {
  std::uint64_t out = 0;
  for (const PixelRect& tile : tiles) out += mix->bricksIn(zone, tile);
  return out;
}

FrameDrawing::FrameDrawing(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress)
    : store_(store),
      cache_(cache),
      request_(request),
      progress_(progress),
      plan_(cache.stores(), request),
      frame_(splatFrameOf(request, plan_.classifier)),
      before_(cache.counts()),
      drawn_together_(drawnTogether(request)) {
  std::size_t levels = 0;
  for (const StoreReader* const one : cache.stores()) levels = std::max(levels, one->manifest().levels.size());
  statistics_.levels.assign(request.volumes.empty() ? store.manifest().levels.size() : levels, {});
}

void FrameDrawing::beginVisibility(const PixelRect& pixels) {
  const bool quincunx = request_.sampling().quincunx;
  // Of two pixels beside each other one speaks for both.
  PixelRect known = pixels;
  if (quincunx) known.x1 += known.x1 % 2;
  visibility_.reset();
  visibility_ = makeVisibilityOf(known, visibilityOf(request_), request_.tile_px);
  frame_.visibility = visibility_.get();
  frames_.clear();
  if (!quincunx) return;
  // Where `pixels` part two of which one has a ray, it is the other one's that would hide both: nobody asks it.
  const auto close = [&](int x) {
    for (int y = pixels.y0 + (x + pixels.y0 + 1) % 2; y < pixels.y1; y += 2) visibility_->close(x, y);
  };
  if (pixels.x0 % 2 != 0) close(pixels.x0);
  if (pixels.x1 % 2 != 0) close(pixels.x1 - 1);
}

Image FrameDrawing::draw(const PixelRect& pixels) {
  beginVisibility(pixels);
  // Only bricks whose light is composited one by one say where they showed something.
  shown_ = plan_.mix || plan_.projection ? pixels : PixelRect{};
  Image image = emptyImage(pixels, request_.aovs);
  if (plan_.projection)
    project(pixels, image);
  else
    composite(pixels, image);
  part_->finish();
  return image;
}

void FrameDrawing::composite(const PixelRect& pixels, Image& image) {
  const ProfileScope span(Activity::kWalk);
  TilePixels all{pixels, image.pixel(0, 0), std::ptrdiff_t{4} * image.width, aovPixels(request_.aovs, image, 0, 0)};
  if (request_.deep) image.deep = std::make_shared<DeepSamples>(pixels, *request_.deep, request_.view.origin_depth);
  all.deep = image.deep.get();
  if (plan_.mix) {
    mix(all);
    return;
  }
  BrickWalkCounts ignored;
  std::vector<BrickInView> in_view = plan_.bricks->inView(pixels, ignored);
  part_.emplace(progress_, "bricks", in_view.size());
  lookahead_.emplace(std::move(in_view), [&](const BrickInView& brick, std::span<const PixelRect> before) {
    return plan_.bricks->hidden(brick, *visibility_, before);
  });
  // The first bricks, too, are read by all threads.
  announceNext();
  const auto draw = [&](const BrickKey& key, const PixelRect& rect) {
    progress_.throwIfCancelled("rendering");
    std::shared_ptr<const BrickBlock> block = blockOf({key, rect}, all);
    const std::size_t passed = lookahead_->turnOf(key);
    announceNext();
    if (block)
      due_.push_back({std::move(block), rect, {}, nullptr, {}});
    else
      lookahead_->drew(key, false);
    // Those before it are drawn or hidden, but for those that are due.
    part_->reached(passed - due_.size());
    if (due_.size() == drawn_together_) drawDue(all);
  };
  plan_.bricks->run(pixels, *visibility_, draw, walked_, request_.node_log);
  drawDue(all);
}

std::vector<PixelRect> tilesOf(int tile_px, const PixelRect& drawn, const PixelRect& rect) {
  const int edge = tile_px;
  if (edge == 0) return {drawn};
  std::vector<PixelRect> out;
  for (int y = rect.y0 / edge * edge; y < rect.y1; y += edge) {
    for (int x = rect.x0 / edge * edge; x < rect.x1; x += edge)
      out.push_back(intersection(PixelRect{x, y, x + edge, y + edge}, drawn));
  }
  return out;
}

std::shared_ptr<const BrickBlock> FrameDrawing::blockOf(const BrickInView& brick, const TilePixels& all) {
  if (!due_.empty()) {
    std::shared_ptr<const BrickBlock> block = mayHide(brick) ? nullptr : cache_.find(brick.key);
    if (block) return block;
    // While it is read, those that are due are drawn; they may hide it.
    drawDue(all);
    if (plan_.bricks->hidden(brick, *visibility_)) {
      ++walked_.hidden;
      return nullptr;
    }
  }
  std::shared_ptr<const BrickBlock> block = cache_.get(brick.key);
  if (!block) statistics_.damaged.insert({brick.key});
  return block;
}

bool FrameDrawing::mayHide(const BrickInView& brick) const {
  if (due_.size() < kEnoughBricksTogether) return false;
  std::vector<PixelRect> covered;
  for (const DueBrick& due : due_) covered.push_back(due.rect);
  return plan_.bricks->hidden(brick, *visibility_, covered);
}

std::vector<FrameDrawing::DueTile> FrameDrawing::dueTiles(const PixelRect& drawn) const {
  std::map<std::pair<int, int>, std::size_t> places;
  std::vector<DueTile> out;
  for (std::size_t i = 0; i < due_.size(); ++i) {
    for (const PixelRect& tile : tilesOf(drawn, due_[i].rect)) {
      const auto [place, is_new] = places.try_emplace({tile.x0, tile.y0}, out.size());
      if (is_new) out.push_back({tile, {}, {}, 0});
      out[place->second].bricks.push_back(i);
      out[place->second].pixels += intersection(due_[i].rect, tile).count();
    }
  }
  for (DueTile& tile : out) tile.counts.resize(tile.bricks.size());
  std::stable_sort(out.begin(), out.end(), [](const DueTile& a, const DueTile& b) { return a.pixels > b.pixels; });
  return out;
}

void FrameDrawing::drawDue(const TilePixels& all) {
  if (due_.empty()) return;
  ProfileScope span(Activity::kBrick);
  if (span.traced()) span.note("bricks", due_.size());
  if (plan_.pixel) {
    parallelFor(due_.size(), [&](std::size_t i) { due_[i].zones = plan_.pixel->cellsOf(*due_[i].block); });
  } else {
    for (DueBrick& brick : due_) brick.frame = &frameOf(brick.block->key.level);
  }
  std::vector<DueTile> tiles = dueTiles(all.rect);
  std::atomic<std::size_t> drawn = 0;
  parallelForInOrder(tiles.size(), [&](std::size_t i) {
    progress_.throwIfCancelled("rendering");
    DueTile& tile = tiles[i];
    for (std::size_t k = 0; k < tile.bricks.size(); ++k)
      drawTile(due_[tile.bricks[k]], all.of(tile.rect), tile.counts[k]);
    part_->within(due_.size(), ++drawn, tiles.size());
  });
  for (const DueTile& tile : tiles) {
    for (std::size_t k = 0; k < tile.bricks.size(); ++k) {
      due_[tile.bricks[k]].counts.add(tile.counts[k]);
      if (tile.counts[k].changed) shown_ = aroundBoth(shown_, tile.rect);
    }
  }
  for (const DueBrick& brick : due_) count(brick.block->key, brick.counts);
  due_.clear();
}

void FrameDrawing::drawTile(const DueBrick& brick, const TilePixels& tile, DrawCounts& counts) {
  if (plan_.pixel) {
    plan_.pixel->drawTile(*brick.block, brick.zones, tile, *visibility_, frame_.opaque_at, counts);
    return;
  }
  const TileScope span(brick.block->key, tile.rect, counts);
  planes_.lend([&](TilePlanes& planes) {
    planes.reserve(tile.rect);
    walkTile(*brick.frame, *brick.block, tile, planes, counts, request_.node_log);
  });
}

void FrameDrawing::count(const BrickKey& key, const DrawCounts& drawn) {
  counts_.add(drawn);
  lookahead_->drew(key, drawn.changed);
  statistics_.levels[static_cast<std::size_t>(key.level)].add(drawn.visited, drawn.splats);
  if (drawn.changed) statistics_.addContributing({key}, store_.index().at(key).file_bytes);
}

const SplatContext& FrameDrawing::frameOf(int level) {
  const auto known = frames_.find(level);
  return known != frames_.end() ? known->second : frames_.emplace(level, frameOfLevel(level)).first->second;
}

SplatContext FrameDrawing::frameOfLevel(int level) const {
  SplatContext out = frame_;
  out.projector = &plan_.levels.projector(level);
  const float noise = gradientNoiseOf(store_.manifest(), request_.transfer_function);
  out.shader = Shader(request_.shading, request_.view, noise, *out.projector);
  out.light_is_plain = isPlain(request_.shading);
  out.view = VoxelView(*out.projector, plainLight(request_.shading, noise, *out.projector));
  out.gradient_opacity = GradientOpacity(request_.transfer_function, opacityUnit(store_, request_), *out.projector);
  out.clip = &plan_.levels.clipRegion(level);
  out.part = out.clip->part().voxels();
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
  out.bricks_damaged = out.damaged.size();
  out.bricks_read_bytes = after.read_bytes - before_.read_bytes;
  out.bricks_shared = after.shared - before_.shared;
  out.bricks_shared_bytes = after.shared_bytes - before_.shared_bytes;
  out.slab_bytes = plan_.mix ? plan_.mix->bytes() : planes_.bytes();
  out.load_s = after.load_seconds - before_.load_seconds;
  return out;
}

}  // namespace kiln
