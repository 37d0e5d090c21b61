#include "engine/pixel/pixel_lattice.h"

#include <algorithm>

#include "engine/pixel/cast_cells.h"
#include "traverse/tile_scope.h"

namespace kiln {
PixelLattice::PixelLattice(const Manifest& volume, const FrameLevels& levels, const View& view,
                           const Sampling& sampling, const TransferFunction& transfer_function, const Shading& shading,
                           float gradient_noise)
    : brick_size_(volume.brick_size),
      table_(transfer_function, transfer_function.unitIn(volume.geometry().meanSpacing()), volume.type, volume.range),
      zones_(levels, slabZones(zonedVolume(volume, levels, sampling), view, sampling.level)) {
  const VolumeAppearance look{
      transfer_function,     shading, view, transfer_function.unitIn(volume.geometry().meanSpacing()), gradient_noise,
      sampling.interpolation};
  for (std::size_t i = 0; i < zones_.zones().size(); ++i) {
    const SlabZone& zone = zones_.zones()[i];
    frames_.push_back(zoneFrame(zone, levels, table_, look));
    rays_.emplace_back(zones_.zones(), i, levels.projector(zone.level), levels.dims(zone.level),
                       levels.endVoxels(zone.level), sampling.quincunx);
  }
}

BrickWalk::VisiblePart PixelLattice::anyPart() const {
  return [this](int level, const VoxelBox& core, const BrickEntry& entry, const BrickWalk::RectTest& test) {
    const DepthZones::Depths depths = zones_.depthsOf(level, core);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const SlabZone& zone = zones_.zones()[i];
      if (zone.level != level || !DepthZones::reaches(depths, zone)) continue;
      if (anyPartIn(*frames_[i], core, brick_size_, entry, test)) return true;
    }
    return false;
  };
}

std::vector<PixelLattice::ZoneCells> PixelLattice::cellsOf(const BrickBlock& block) const {
  const ProfileScope span(Activity::kCells);
  const DepthZones::Depths depths = zones_.depthsOf(block.key.level, block.core);
  std::vector<ZoneCells> out;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const SlabZone& zone = zones_.zones()[i];
    if (zone.level != block.key.level || !DepthZones::reaches(depths, zone)) continue;
    out.push_back({frames_[i].get(), &rays_[i], visibleCells(*frames_[i], block)});
  }
  return out;
}

// A brick lies in two zones, or in three where the eye is near.
std::uint64_t PixelLattice::cellBytes(std::int64_t brick_size) {
  const auto edge = static_cast<std::uint64_t>(brick_size / kCellSize);
  return 2 * edge * edge * edge * sizeof(SlabCell);
}

void PixelLattice::drawTile(const BrickBlock& block, const std::vector<ZoneCells>& zones, const TilePixels& tile,
                            Visibility& visibility, float opaque_at, DrawCounts& counts) const {
  const TileScope span(block.key, tile.rect, counts);
  const std::vector<TilePixels> squares = squaresOf(tile);
  for (const ZoneCells& zone : zones) {
    for (const TilePixels& square : squares)
      castCells(*zone.rays, *zone.frame, block, zone.cells, square, visibility, opaque_at, counts);
  }
}

}  // namespace kiln
