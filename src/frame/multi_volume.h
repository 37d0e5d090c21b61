// Several volumes in one picture: one set of slabs for all (engine/shared/slab_grid.h), zone after zone from near to
// far. In a zone each volume has the level that its own voxels need, and in each tile samples of all volumes are added
// up slab by slab (engine/pixel/slab_sums.h), so that no bit depends on how a volume was cut.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/thread/memory_pool.h"
#include "cache/brick_cache.h"
#include "engine/pixel/ray_slabs.h"
#include "engine/pixel/slab_sums.h"
#include "engine/pixel/zone_frames.h"
#include "engine/shared/draw_counts.h"

namespace kiln {

/// What a frame shows of a volume.
struct MixedVolume {
  const StoreReader* store = nullptr;
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;
};

struct MixView {
  View view;
  ProjectedArea area = ProjectedArea::kBox;
  Sampling sampling;  // of all volumes
};

class MultiVolume {
 public:
  /// A brick that shows something in a zone, and where.
  struct Brick {
    StoredBrick brick;
    PixelRect rect;
    std::uint64_t bytes = 0;  // once it is decoded, with a list of its cells
  };
  using Blocks = std::vector<std::shared_ptr<const BrickBlock>>;

  /// requires: the stores outlive this; kMostVolumes of them at most. throws: as FrameLevels. cost: a look at every
  /// brick of the levels that the view asks for.
  MultiVolume(std::vector<MixedVolume> volumes, const MixView& view);
  MultiVolume(const MultiVolume&) = delete;
  MultiVolume& operator=(const MultiVolume&) = delete;

  /// From the nearest to the farthest.
  std::size_t zones() const { return zones_.size(); }
  /// Of the volume in that zone; nothing where it has none.
  std::optional<int> levelOf(std::size_t zone, std::size_t volume) const {
    return zones_[zone].frames[volume] ? std::optional(zones_[zone].slabs[volume].level) : std::nullopt;
  }
  /// Those in the picture.
  const std::vector<Brick>& bricksOf(std::size_t zone) const { return zones_[zone].bricks; }
  /// How many of them touch the tile.
  std::uint64_t bricksIn(std::size_t zone, const PixelRect& tile) const;
  /// Of all zones, each once: those of the levels that the view asks for, and of these those that show something, in
  /// the picture or not.
  const BrickWalkCounts& counts() const { return counts_; }
  /// Each brick once that touches the pixels.
  std::vector<StoredBrick> inView(const PixelRect& pixels) const;
  /// The most that bricks of one of the tiles take at once. unit: bytes.
  std::uint64_t mostBytes(std::span<const PixelRect> tiles) const;
  /// What the bricks of a zone take that touch one of the tiles, with reading the last of them. unit: bytes.
  std::uint64_t bytesFor(std::span<const Brick* const> bricks) const;

  /// Draws the tiles' pixels of the zone, in parallel. shape: `blocks` are those of `bricks`, null where a brick is
  /// left out; the result is a count for each volume. requires: zones in order; `bricks` are all of the zone that touch
  /// one of the tiles and are not hidden. `tile_drawn` is told the place of each that is, by any thread.
  std::vector<DrawCounts> draw(std::size_t zone, std::span<const Brick* const> bricks, const Blocks& blocks,
                               const std::vector<TilePixels>& tiles, Visibility& visibility, float opaque_at,
                               const std::function<void(std::size_t)>& tile_drawn);

  /// What its threads have needed so far. unit: bytes.
  std::uint64_t bytes() const { return sums_.bytes(); }

 private:
  struct Volume {
    explicit Volume(MixedVolume mixed, const MixView& view);
    MixedVolume mixed;
    double unit;  // that opacities are per
    FrameLevels levels;
    SampleTable table;
  };
  struct Zone {
    std::vector<SlabZone> slabs;                     // of each volume
    std::vector<std::unique_ptr<SlabFrame>> frames;  // null where it has none
    std::vector<RaySlabs> rays;                      // of each volume
    std::vector<Brick> bricks;
  };
  /// Cells of a zone's bricks that may show something. shape: a list a brick.
  using Cells = std::vector<std::vector<SlabCell>>;
  /// Bricks of a zone, with their voxels and cells.
  struct ZoneBricks {
    const Zone& zone;
    std::span<const Brick* const> bricks;
    const Blocks& blocks;
    const Cells& cells;
  };
  /// Draws a tile's pixels of a zone in squares. `counts` has a count for each volume.
  void drawTile(const ZoneBricks& drawn, const TilePixels& tile, Visibility& visibility, float opaque_at,
                std::span<DrawCounts> counts);
  void addRays(std::size_t volume);
  void addBricks(std::size_t volume, const PixelRect& picture);
  void addBrick(std::size_t volume, const BrickKey& key, const PixelRect& picture);

  const MixView view_;
  std::vector<std::unique_ptr<Volume>> volumes_;
  std::vector<Zone> zones_;
  BrickWalkCounts counts_;
  std::uint64_t reading_bytes_ = 0;  // beyond what a decoded brick takes, at most
  MemoryPool<SlabSums> sums_;
};

}  // namespace kiln
