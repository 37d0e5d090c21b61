// `--lattice pixel`: one sample where the ray of a pixel meets the middle of a slab.
// Method. Depth decides level and thickness of slabs, in zones (engine/shared/slab_grid.h). A brick is cut into cells;
// in each zone that it reaches, the kernel (engine/pixel/cast_rays_in_cell.h) takes the samples of a cell.
#pragma once

#include <memory>
#include <optional>

#include "engine/engine.h"
#include "engine/engine_memory.h"
#include "engine/pixel/ray_sampling.h"
#include "engine/pixel/zone_contexts.h"
#include "traverse/depth_zones.h"

namespace kiln {

class PixelEngine final : public VolumeEngine {
 public:
  /// requires: `levels` and all of `appearance` outlive this.
  PixelEngine(const Manifest& volume, const FrameLevels& levels, const Sampling& sampling,
              const VolumeAppearance& appearance);
  PixelEngine(const PixelEngine&) = delete;
  PixelEngine& operator=(const PixelEngine&) = delete;

  /// Parts are sub-bricks (store/ranges/sub_bricks.h), in each zone of their level.
  BrickSelection selection() const override;
  /// A cell is loaded once in each tile that it touches.
  bool joinsTiles() const override { return true; }
  std::unique_ptr<const PreparedBrick> prepare(const BrickToDraw& brick) const override;
  void draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) override;

  /// Visible cells of a brick in one zone.
  struct ZoneCells {
    const SlabContext* context;
    const RaySampling* rays;
    std::vector<SlabCell> cells;
  };
  /// Returns the cells of a brick, from the nearest zone to the farthest. requires: this outlives the result. thread:
  /// safe.
  std::vector<ZoneCells> cellsOf(const BrickBlock& block) const;
  static EngineMemory memory(std::int64_t brick_size);

 private:
  struct Prepared;

  const std::int64_t brick_size_;
  SampleTable table_;
  std::optional<SampleTable> colors_;  // of the companion's values
  std::unique_ptr<const CutFaces> faces_;
  DepthZones zones_;
  std::vector<std::unique_ptr<SlabContext>> contexts_;  // one per zone
  std::vector<RaySampling> rays_;                       // one per zone
};

}  // namespace kiln
