// `--mode mip|minip|average`: the greatest, least or mean value along each ray, in a colour of the transfer function.
// Method. Levels are the levels of the pixel lattice. An extremum needs no order of bricks: constant bricks come first,
// then bricks with the most in their own voxels, so that pixels soon hold values that hide the rest. A mean takes all
// bricks, front to back. A pixel's value becomes a colour when all bricks are drawn.
#pragma once

#include <optional>

#include "engine/engine.h"
#include "engine/engine_memory.h"
#include "engine/projection/project_brick.h"
#include "engine/projection/silhouette.h"
#include "traverse/brick_walk.h"
#include "traverse/depth_zones.h"

namespace kiln {

/// - culls: leave out bricks, tiles and cells that can change no pixel.
struct ProjectionOptions {
  PixelValue held = PixelValue::kGreatest;
  std::optional<int> level;
  int coarser = 0;  // Sampling::coarser
  bool culls = true;
  Attenuation attenuation{};
};

class ValueProjection final : public VolumeEngine {
 public:
  /// requires: `store` and `levels`, which are of this store, outlive this.
  ValueProjection(const BrickedVolume& store, const FrameLevels& levels, const View& view,
                  const ProjectionOptions& options);
  ValueProjection(const ValueProjection&) = delete;
  ValueProjection& operator=(const ValueProjection&) = delete;

  static EngineMemory memory(PixelValue held) { return {.pixel = ProjectedValues::bytesOfPixel(held)}; }

  BrickSelection selection() const override;
  /// requires: `begin`.
  std::unique_ptr<const PreparedBrick> prepare(const BrickToDraw& brick) const override;
  /// Takes the values of the bricks into the pixels of the tile. requires: `begin` with the tile's pixels; bricks of a
  /// mean in the order of `ordered`.
  void draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) override;

  /// Forgets all values, and prepares the pixels; pixels whose rays have no value are left out.
  void begin(const PixelRect& pixels);
  /// Returns the bricks in the order of drawing. `front_to_back` is the order of the walk.
  std::vector<BrickInView> ordered(std::vector<BrickInView> front_to_back) const;
  /// Returns whether the brick can change no pixel. requires: `begin`.
  bool hidden(const BrickInView& brick) const;
  /// Writes the colours and values of the pixels, and releases the values: other volumes are drawn after this volume.
  /// requires: all bricks are drawn; `begin` with the target's pixels.
  void finish(const TransferFunction& transfer_function, const TilePixels& target);

 private:
  struct Prepared;
  const BrickEntry& entryOf(const BrickInView& brick) const { return store_.index().at(brick.key); }
  VoxelBox coreOf(const BrickKey& key) const;
  /// Returns the end of level 0 in the index space of `level`.
  glm::dvec3 endOf(int level) const;
  /// Returns the range of the brick's possible values.
  static ValueRange rangeOf(const BrickEntry& entry);
  void drawBrick(const Prepared& brick, const PixelRect& rect, DrawCounts& counts);

  const BrickedVolume& store_;
  const FrameLevels& levels_;
  const PixelValue held_;
  const bool culls_;
  const Attenuation attenuation_;
  DepthZones zones_;
  const Silhouette outline_;
  std::vector<RayFrame> frames_;  // one per level, the finest first
  std::optional<ProjectedValues> values_;
};

}  // namespace kiln
