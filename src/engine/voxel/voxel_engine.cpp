#include "engine/voxel/voxel_engine.h"

#include <utility>

#include "engine/voxel/tile_walk.h"
#include "traverse/brick_walk.h"
#include "traverse/tile_scope.h"

namespace kiln {

struct VoxelEngine::Prepared final : PreparedBrick {
  Prepared(std::shared_ptr<const BrickBlock> the_block, const SplatContext& the_context)
      : block(std::move(the_block)), context(the_context) {}
  const std::shared_ptr<const BrickBlock> block;
  const SplatContext& context;
};

VoxelEngine::VoxelEngine(const Manifest& volume, const FrameLevels& levels, const VolumeAppearance& appearance,
                         const VoxelTests& tests)
    : levels_(levels),
      appearance_(appearance),
      tests_(tests),
      classifier_(appearance.transfer_function, appearance.unit, volume.type, volume.range) {}

EngineMemory VoxelEngine::memory(const ImageSize& tile) {
  return {.tile = TilePlanes::bytesFor(static_cast<std::size_t>(tile.width), static_cast<std::size_t>(tile.height))};
}

BrickSelection VoxelEngine::selection() const { return {voxelLevelChoice(levels_), wholeBrick(classifier_)}; }

std::unique_ptr<const PreparedBrick> VoxelEngine::prepare(const BrickToDraw& brick) const {
  return std::make_unique<Prepared>(brick.block, contextOf(brick.block->key.level));
}

const SplatContext& VoxelEngine::contextOf(int level) const {
  const std::lock_guard lock(mutex_);
  const auto known = contexts_.find(level);
  return known != contexts_.end() ? known->second : contexts_.emplace(level, makeContext(level)).first->second;
}

SplatContext VoxelEngine::makeContext(int level) const {
  const VolumeAppearance& look = appearance_;
  SplatContext out;
  out.classifier = &classifier_;
  out.test_samples = tests_.test_samples;
  out.projector = &levels_.projector(level);
  out.shader = Shader(look.shading, look.view, look.gradients, *out.projector, look.illumination);
  out.light_is_plain = isPlain(look.shading);
  out.view = VoxelView(*out.projector, plainLight(look.shading, look.gradients, *out.projector));
  out.gradient_opacity = GradientOpacity(look.transfer_function, look.unit, *out.projector);
  out.clip = &levels_.clipRegion(level);
  out.part = out.clip->part().voxels();
  out.ends = levels_.endVoxels(level);
  return out;
}

void VoxelEngine::draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) {
  planes_.lend([&](TilePlanes& planes) {
    planes.reserve(target.pixels.rect);
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      const auto& brick = static_cast<const Prepared&>(*bricks[i]);
      const TileScope span(brick.block->key, target.pixels.rect, target.counts[i]);
      walkTile(brick.context, *brick.block, target, planes, target.counts[i], tests_.log);
    }
  });
}

}  // namespace kiln
