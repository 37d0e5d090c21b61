// Several volumes in one picture: one set of slabs for all (engine/shared/slab_grid.h), zone after zone from near to
// far. In a zone each volume has the level that its own voxels need. In each tile samples of all volumes are added
// slab by slab (engine/pixel/slab_sums.h). No bit depends on how a volume was cut.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/thread/memory_pool.h"
#include "engine/engine.h"
#include "engine/engine_memory.h"
#include "engine/pixel/ray_sampling.h"
#include "engine/pixel/slab_sums.h"
#include "engine/pixel/zone_contexts.h"
#include "traverse/brick_walk.h"

namespace kiln {

/// A volume and its look.
struct MixedVolume {
  const BrickedVolume* store = nullptr;
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;
  std::shared_ptr<const CompanionColors> colors{};  // VolumeAppearance::colors
};

struct MixView {
  View view;
  ProjectedArea area = ProjectedArea::kBox;
  Sampling sampling;  // for all volumes
  const Illumination* illumination = nullptr;
};

class MultiVolume {
 public:
  /// A brick that shows something in a zone, and its pixels.
  struct Brick {
    StoredBrick brick;
    PixelRect rect;
    std::uint64_t block_bytes = 0, cell_bytes = 0;  // memory of the decoded brick, and of a list of its cells
  };

  /// requires: the stores outlive this; kMostVolumes of them at most. throws: as FrameLevels. cost: a look at every
  /// brick of the levels that the view needs.
  MultiVolume(std::vector<MixedVolume> volumes, const MixView& view);
  ~MultiVolume();
  MultiVolume(const MultiVolume&) = delete;
  MultiVolume& operator=(const MultiVolume&) = delete;

  static EngineMemory memory(std::int64_t brick_size, bool layers);

  /// From the nearest to the farthest.
  std::size_t zones() const { return zones_.size(); }
  /// Returns the engine that draws the bricks of a zone. A call of `draw` composites all its bricks. requires: zones in
  /// order; the bricks of a tile are all bricks of the zone that touch the tile and are not hidden.
  Engine& engine(std::size_t zone);
  /// Returns the bricks of a zone that lie in the picture.
  const std::vector<Brick>& bricksOf(std::size_t zone) const { return zones_[zone].bricks; }
  /// Returns how many bricks of the zone touch the tile.
  std::uint64_t bricksIn(std::size_t zone, const PixelRect& tile) const;
  /// Counts of all zones, each brick once: all bricks of the levels that the view needs, and of these the bricks that
  /// show something, in the picture or not.
  const BrickWalkCounts& counts() const { return counts_; }
  /// Returns each brick that touches the pixels, once.
  std::vector<StoredBrick> inView(const PixelRect& pixels) const;
  /// Returns the most memory that the bricks of one of the tiles take at once. unit: bytes.
  std::uint64_t mostBytes(std::span<const PixelRect> tiles) const;
  /// Returns the memory of these bricks, with reading the last brick. unit: bytes.
  std::uint64_t bytesFor(std::span<const Brick* const> bricks) const;
  /// Returns the share of the lists of cells in this memory. unit: bytes.
  static std::uint64_t cellBytesFor(std::span<const Brick* const> bricks);
  /// Memory that the threads have drawn with so far, at most. unit: bytes.
  std::uint64_t scratchBytes() const { return sums_.bytes(); }

 private:
  class ZoneEngine;
  struct Volume {
    explicit Volume(MixedVolume mixed, const MixView& view);
    MixedVolume mixed;
    VolumeAppearance appearance;
    FrameLevels levels;
    SampleTable table;
    std::optional<SampleTable> colors;  // of the companion
    std::unique_ptr<const CutFaces> faces;
  };
  struct Zone {
    std::vector<SlabZone> slabs;                         // one for each volume
    std::vector<std::unique_ptr<SlabContext>> contexts;  // one per volume; null outside the zone
    std::vector<RaySampling> rays;                       // one for each volume
    std::vector<Brick> bricks;
    std::unique_ptr<ZoneEngine> engine;
  };
  void addRays(std::size_t volume);
  void addBricks(std::size_t volume, const PixelRect& picture);
  void addBrick(std::size_t volume, const BrickKey& key, const PixelRect& picture);

  const MixView view_;
  std::vector<std::unique_ptr<Volume>> volumes_;
  std::vector<Zone> zones_;
  BrickWalkCounts counts_;
  std::uint64_t reading_bytes_ = 0;  // beyond the bytes of a decoded brick, at most
  MemoryPool<SlabSums> sums_;
};

}  // namespace kiln
