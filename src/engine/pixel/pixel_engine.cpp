#include "engine/pixel/pixel_engine.h"

#include <algorithm>
#include <utility>

#include "engine/pixel/ray_caster.h"
#include "traverse/tile_scope.h"

namespace kiln {
namespace {

// A sample lies across faces: the test of a cut looks at voxels beside a brick (SlabContext::cutOff). unit: voxels.
constexpr std::int64_t kCutGhosts = 1;

// A cell's voxels and samples (CellSamples), per thread. unit: bytes.
constexpr std::uint64_t kCellBytes = 512u << 10;

}  // namespace

struct PixelEngine::Prepared final : PreparedBrick {
  Prepared(std::shared_ptr<const BrickBlock> the_block, std::vector<ZoneCells> the_zones)
      : block(std::move(the_block)), zones(std::move(the_zones)) {}
  const std::shared_ptr<const BrickBlock> block;
  const std::vector<ZoneCells> zones;
};

PixelEngine::PixelEngine(const Manifest& volume, const FrameLevels& levels, const Sampling& sampling,
                         const VolumeAppearance& appearance)
    : brick_size_(volume.brick_size),
      table_(appearance.transfer_function, appearance.unit, volume.type, volume.range),
      colors_(colorTable(appearance)),
      faces_(cutFacesOf(appearance.section, volume, levels, table_)),
      zones_(levels, slabZones(zonedVolume(volume, levels, sampling), appearance.view, sampling.level)) {
  for (std::size_t i = 0; i < zones_.zones().size(); ++i) {
    const SlabZone& zone = zones_.zones()[i];
    contexts_.push_back(zoneContext(zone, levels, tablesOf(table_, colors_, faces_.get()), appearance));
    rays_.emplace_back(zones_.zones(), i, levels.projector(zone.level), levels.dims(zone.level),
                       levels.endVoxels(zone.level), sampling.quincunx);
  }
}

BrickSelection PixelEngine::selection() const {
  const auto visible_part = [this](int level, const VoxelBox& core, const BrickEntry& entry, const RectTest& test) {
    const DepthZones::Depths depths = zones_.depthsOf(level, core);
    for (std::size_t i = 0; i < contexts_.size(); ++i) {
      const SlabZone& zone = zones_.zones()[i];
      if (zone.level != level || !DepthZones::reaches(depths, zone)) continue;
      if (anyPartIn(*contexts_[i], core, brick_size_, entry, test)) return true;
    }
    return false;
  };
  return {zones_.levelChoice(), visible_part, kCutGhosts};
}

std::unique_ptr<const PreparedBrick> PixelEngine::prepare(const BrickToDraw& brick) const {
  return std::make_unique<Prepared>(brick.block, cellsOf(*brick.block));
}

std::vector<PixelEngine::ZoneCells> PixelEngine::cellsOf(const BrickBlock& block) const {
  const ProfileScope span(Activity::kCells);
  const DepthZones::Depths depths = zones_.depthsOf(block.key.level, block.core);
  std::vector<ZoneCells> out;
  for (std::size_t i = 0; i < contexts_.size(); ++i) {
    const SlabZone& zone = zones_.zones()[i];
    if (zone.level != block.key.level || !DepthZones::reaches(depths, zone)) continue;
    out.push_back({contexts_[i].get(), &rays_[i], visibleCells(*contexts_[i], block)});
  }
  return out;
}

EngineMemory PixelEngine::memory(std::int64_t brick_size) {
  const auto edge = static_cast<std::uint64_t>(brick_size / kCellSize);
  // Cell lists of a brick: a brick lies in two zones, or in three where the eye is near.
  return {.thread = kCellBytes, .brick = 2 * edge * edge * edge * sizeof(SlabCell)};
}

void PixelEngine::draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) {
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const auto& brick = static_cast<const Prepared&>(*bricks[i]);
    const TileScope span(brick.block->key, target.pixels.rect, target.counts[i]);
    for (const ZoneCells& zone : brick.zones)
      castRays(*zone.rays, *zone.context, *brick.block, zone.cells, target.pixels, target.visibility,
               target.opacity_threshold, target.counts[i]);
  }
}

}  // namespace kiln
