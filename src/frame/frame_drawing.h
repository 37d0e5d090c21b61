// What is done once for a frame, and then any part of its picture, one after the other. All is in pixels of the whole
// picture (view, tiles, visibility), so that a pixel is the same bit for bit with whatever part it is drawn.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "base/progress.h"
#include "base/thread/memory_pool.h"
#include "cache/brick_cache.h"
#include "engine/pixel/pixel_lattice.h"
#include "engine/projection/value_projection.h"
#include "engine/shared/draw_counts.h"
#include "engine/voxel/splat_cell.h"
#include "frame/frame_progress.h"
#include "frame/multi_volume.h"
#include "frame/render_frame.h"
#include "frame/statistics.h"
#include "image/image.h"
#include "traverse/prefetcher.h"

namespace kiln {

/// What of the volume a frame asks for, before any of it is read.
struct FramePlan {
  /// The stores' first is the volume, or all of them are together.
  FramePlan(const std::vector<const StoreReader*>& stores, const FrameRequest& request);
  FramePlan(const FramePlan&) = delete;
  FramePlan& operator=(const FramePlan&) = delete;

  FrameLevels levels;
  Classifier classifier;
  // Of these at most one; with none it is the voxel lattice.
  std::optional<PixelLattice> pixel;
  std::optional<ValueProjection> projection;
  std::optional<MultiVolume> mix;
  std::optional<BrickWalk> bricks;  // not of several volumes

  /// What drawing these pixels counts as it goes on (frame/frame_progress.h): bricks, or of several volumes the tiles
  /// that each brick of each zone is drawn into.
  std::uint64_t stepsOf(const PixelRect& pixels, int tile_px) const;
  std::uint64_t stepsOf(std::size_t zone, std::span<const PixelRect> tiles) const;
};

/// The tiles of the whole frame that `rect` touches, cut off at what is drawn.
std::vector<PixelRect> tilesOf(int tile_px, const PixelRect& drawn, const PixelRect& rect);

class FrameDrawing {
 public:
  /// Bricks announced to the cache at a time: enough to keep every reader busy while one brick is drawn.
  static constexpr std::size_t kAnnounced = 8;

  /// requires: all outlive this; nobody else uses the cache.
  FrameDrawing(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress);

  /// The pixels of `pixels`, without background, their planes as sums (engine/shared/aov_pixels.h). requires: not
  /// empty, in the picture. throws: as renderFrame.
  Image draw(const PixelRect& pixels);
  /// What of the pixels that were drawn last shows something; the others' colours are zero.
  const PixelRect& shown() const { return shown_; }
  /// What all that was drawn has cost, but for the time. Announces nothing to the cache any more.
  FrameStatistics finish();

 private:
  /// Makes the structure of what is drawn: nothing of it is opaque, whatever has been drawn before.
  void beginVisibility(const PixelRect& pixels);
  /// What `draw` does where light is composited, and where values are projected.
  void composite(const PixelRect& pixels, Image& image);
  void project(const PixelRect& pixels, Image& image);
  void announceNext() {
    if (cache_.readsAhead()) cache_.announce(lookahead_->next(kAnnounced));
  }
  /// The same of several volumes.
  void mix(const TilePixels& all);
  void mixTiles(std::size_t zone, const TilePixels& all, std::span<const PixelRect> tiles);
  void announce(std::span<const MultiVolume::Brick* const> bricks);
  void announceBehind(std::size_t zone, std::span<const PixelRect> tiles);
  /// Tells how far it is, tile after tile.
  void drawMixed(std::size_t zone, std::span<const MultiVolume::Brick* const> bricks, const MultiVolume::Blocks& blocks,
                 const TilePixels& all, std::span<const PixelRect> tiles);
  std::vector<const MultiVolume::Brick*> toBeMixed(std::size_t zone, std::span<const PixelRect> tiles) const;
  std::vector<PixelRect> tilesOf(const PixelRect& drawn, const PixelRect& rect) const {
    return kiln::tilesOf(request_.tile_px, drawn, rect);
  }
  /// A brick whose turn has come, what of the image it can touch, and what its tiles share.
  struct DueBrick {
    std::shared_ptr<const BrickBlock> block;
    PixelRect rect;
    std::vector<PixelLattice::ZoneCells> zones;  // not of the voxel lattice
    const SplatContext* frame = nullptr;         // of the voxel lattice
    DrawCounts counts;
  };
  /// A tile and, front to back, the bricks that are drawn into it, by their places among those that are due.
  struct DueTile {
    PixelRect rect;
    std::vector<std::size_t> bricks;
    std::vector<DrawCounts> counts;
    std::uint64_t pixels;  // that its bricks may touch, each its own: what its time is likely to grow with
  };
  /// Whether those that are due would hide it, were they opaque, and are enough to keep threads busy.
  bool mayHide(const BrickInView& brick) const;
  /// The brick if it may be drawn with those that are due, else, when these are drawn and it is still seen, from disk.
  std::shared_ptr<const BrickBlock> blockOf(const BrickInView& brick, const TilePixels& all);
  /// Draws the bricks that are due, tiles in parallel.
  void drawDue(const TilePixels& all);
  /// Those that are likely to take longest come first.
  std::vector<DueTile> dueTiles(const PixelRect& drawn) const;
  void drawTile(const DueBrick& brick, const TilePixels& tile, DrawCounts& counts);
  /// Adds what drawing a brick has cost.
  void count(const BrickKey& key, const DrawCounts& drawn);
  /// What the voxel lattice's kernels are told; made once for what is being drawn.
  const SplatContext& frameOf(int level);
  SplatContext frameOfLevel(int level) const;

  const StoreReader& store_;
  BrickCache& cache_;
  const FrameRequest& request_;
  Progress& progress_;
  FramePlan plan_;
  std::unique_ptr<Visibility> visibility_;  // of what is being drawn
  SplatContext frame_;                      // without what depends on a level
  std::map<int, SplatContext> frames_;      // by level, of what is being drawn
  MemoryPool<TilePlanes> planes_;           // of the voxel lattice
  const CacheCounts before_;
  FrameStatistics statistics_;
  DrawCounts counts_;
  BrickWalkCounts walked_;
  std::set<StoredBrick> mixed_;
  const std::size_t drawn_together_;
  std::optional<Prefetcher> lookahead_;  // of what is being drawn, but for several volumes
  std::vector<DueBrick> due_;
  PixelRect shown_;                   // of what is being drawn
  std::optional<PartProgress> part_;  // of what is being drawn
  std::uint64_t mixed_steps_ = 0;     // of it, where it has several volumes
};

}  // namespace kiln
