#include "frame/pixel_lattice.h"

#include <algorithm>

#include "frame/tile_span.h"

namespace kiln {
namespace {

// A tile's squares are swept by its thread: pixels of a tile are closed by one thread at a time.
std::vector<TilePixels> squaresOf(const TilePixels& tile, int edge) {
  std::vector<TilePixels> out;
  for (int y = tile.rect.y0; y < tile.rect.y1; y += edge) {
    for (int x = tile.rect.x0; x < tile.rect.x1; x += edge) {
      out.push_back(tile.of(intersection(PixelRect{x, y, x + edge, y + edge}, tile.rect)));
    }
  }
  return out;
}

// Where the samples of a sub-brick are, with those of the apron beside it, which no other has.
VoxelBox samplesOf(VoxelBox sub_brick, const VoxelBox& core, const VoxelBox& reach) {
  for (int axis = 0; axis < 3; ++axis) {
    if (sub_brick.lo[axis] == core.lo[axis]) sub_brick.lo[axis] = reach.lo[axis];
    if (sub_brick.hi[axis] == core.hi[axis]) sub_brick.hi[axis] = reach.hi[axis];
  }
  return sub_brick;
}

}  // namespace

PixelLattice::PixelLattice(const Manifest& volume, const FrameLevels& levels, const View& view,
                           std::optional<int> level, Interpolation interpolation,
                           const TransferFunction& transfer_function, const Shading& shading, float gradient_noise,
                           int sweep_px)
    : brick_size_(volume.brick_size),
      sweep_px_(sweep_px),
      zones_(levels, slabZones(volume, view, level, levels.projector(levels.finest()).nearDepth())),
      table_(transfer_function, transfer_function.unitIn(volume.geometry().meanSpacing()), volume.type, volume.range) {
  const double unit = transfer_function.unitIn(volume.geometry().meanSpacing());
  for (const SlabZone& zone : zones_.zones()) {
    const Projector& projector = levels.projector(zone.level);
    const SampleLook look{shading,
                          Shader(shading, view, gradient_noise, projector),
                          GradientOpacity(transfer_function, unit, projector),
                          &levels.clipRegion(zone.level),
                          gradient_noise,
                          interpolation};
    frames_.push_back(std::make_unique<SlabFrame>(zone, projector, levels.dims(zone.level),
                                                  levels.endVoxels(zone.level), table_, look));
  }
}

BrickWalk::AnyPart PixelLattice::anyPart() const {
  return [this](int level, const VoxelBox& core, const BrickEntry& entry, const BrickWalk::PartTest& test) {
    const DepthZones::Depths depths = zones_.depthsOf(level, core);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const SlabZone& zone = zones_.zones()[i];
      if (zone.level != level || !DepthZones::reaches(depths, zone)) continue;
      if (anyPartIn(*frames_[i], core, brick_size_, entry, test)) return true;
    }
    return false;
  };
}

bool PixelLattice::anyPartIn(const SlabFrame& frame, const VoxelBox& core, std::int64_t brick_size,
                             const BrickEntry& entry, const BrickWalk::PartTest& test) {
  if (!frame.interesting(entry.support)) return false;
  const VoxelBox volume = boxOf(frame.dims()), reach = intersection(dilated(core, frame.ghosts()), volume);
  const auto passes = [&](const VoxelBox& samples) {
    if (frame.look().clip->classify(samples) == ClipRegion::Overlap::kOutside) return false;
    const SlabFrame::Bounds bounds = frame.boundsOf(samples);
    return !bounds.empty() && test(bounds.rect);
  };
  if (!entry.sub_ranges) return passes(reach);
  return anySubBrick([&](std::size_t i, const VoxelCoord& at) {
    return frame.interesting(entry.sub_ranges->at(i, entry.support)) &&
           passes(samplesOf(subBrickOf(core, brick_size, at), core, reach));
  });
}

std::vector<PixelLattice::ZoneCells> PixelLattice::cellsOf(const BrickBlock& block) const {
  const Span span(Activity::kCells);
  const DepthZones::Depths depths = zones_.depthsOf(block.key.level, block.core);
  std::vector<ZoneCells> out;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const SlabZone& zone = zones_.zones()[i];
    if (zone.level != block.key.level || !DepthZones::reaches(depths, zone)) continue;
    out.push_back({frames_[i].get(), interestingCells(*frames_[i], block)});
  }
  return out;
}

// A brick lies in two zones, or in three where the eye is near.
std::uint64_t PixelLattice::cellBytes(std::int64_t brick_size) {
  const auto edge = static_cast<std::uint64_t>(brick_size / kCellSize);
  return 2 * edge * edge * edge * sizeof(SlabCell);
}

void PixelLattice::drawTile(const BrickBlock& block, const std::vector<ZoneCells>& zones, const TilePixels& tile,
                            Visibility& visibility, bool test_samples, float opaque_at, SplatCounts& counts) {
  const TileSpan span(block.key, tile.rect, counts);
  std::unique_ptr<SweepMemory> memory = takeMemory();
  const std::vector<TilePixels> squares = squaresOf(tile, sweep_px_);
  std::vector<const SlabCell*> touching;
  for (const ZoneCells& zone : zones) {
    for (const TilePixels& square : squares) {
      touching.clear();
      for (const SlabCell& cell : zone.cells) {
        if (!intersection(cell.bounds.rect, square.rect).empty()) touching.push_back(&cell);
      }
      sweepSlabs(*zone.frame, block, touching, square, visibility, test_samples, opaque_at, *memory, counts);
    }
  }
  const std::lock_guard lock(mutex_);
  memory_.push_back(std::move(memory));
}

std::uint64_t PixelLattice::bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const std::unique_ptr<SweepMemory>& memory : memory_) sum += memory->bytes();
  return sum;
}

std::unique_ptr<SweepMemory> PixelLattice::takeMemory() {
  const std::lock_guard lock(mutex_);
  if (memory_.empty()) return std::make_unique<SweepMemory>();
  std::unique_ptr<SweepMemory> out = std::move(memory_.back());
  memory_.pop_back();
  return out;
}

}  // namespace kiln
