// `--lattice voxel`: every voxel, once, as the footprint of a Gaussian (Lee and Ihm's algorithm to the letter).
// Method. The octree of a brick is walked front to back for each tile (engine/voxel/tile_walk.h).
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "base/thread/memory_pool.h"
#include "engine/engine.h"
#include "engine/engine_memory.h"
#include "engine/shared/classifier.h"
#include "engine/shared/volume_appearance.h"
#include "engine/voxel/splat_cell.h"
#include "traverse/frame_levels.h"
#include "traverse/node_log.h"

namespace kiln {

/// - test_samples: leave out voxels all of whose pixels are closed, before they are shaded.
/// - log: receives every node that is tested, with one tile per frame; may be null.
struct VoxelTests {
  bool test_samples = true;
  NodeLog* log = nullptr;
};

class VoxelEngine final : public VolumeEngine {
 public:
  /// requires: `levels`, the log and all of `appearance` outlive this.
  VoxelEngine(const Manifest& volume, const FrameLevels& levels, const VolumeAppearance& appearance,
              const VoxelTests& tests);
  VoxelEngine(const VoxelEngine&) = delete;
  VoxelEngine& operator=(const VoxelEngine&) = delete;

  BrickSelection selection() const override;
  std::unique_ptr<const PreparedBrick> prepare(const BrickToDraw& brick) const override;
  void draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) override;
  std::uint64_t scratchBytes() const override { return planes_.bytes(); }

  static EngineMemory memory(const ImageSize& tile);

  const Classifier& classifier() const { return classifier_; }
  /// Returns what all bricks of a level share, made when the level is needed first. thread: safe.
  const SplatContext& contextOf(int level) const;

 private:
  struct Prepared;
  SplatContext makeContext(int level) const;

  const FrameLevels& levels_;
  const VolumeAppearance appearance_;
  const VoxelTests tests_;
  const Classifier classifier_;
  mutable std::mutex mutex_;
  mutable std::map<int, SplatContext> contexts_;  // by level
  MemoryPool<TilePlanes> planes_;
};

}  // namespace kiln
