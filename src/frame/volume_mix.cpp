#include "frame/volume_mix.h"

#include <algorithm>
#include <set>

#include "base/parallel.h"
#include "base/span.h"
#include "frame/depth_zones.h"
#include "splat/join_volumes.h"

namespace kiln {
namespace {

double unitOf(const MixedVolume& volume) {
  return volume.transfer_function.unitIn(volume.store->manifest().geometry().meanSpacing());
}

}  // namespace

VolumeMix::Volume::Volume(MixedVolume the_mixed, const MixView& view)
    : mixed(std::move(the_mixed)),
      unit(unitOf(mixed)),
      levels(mixed.store->manifest(), view.sampling.level, view.view, view.area, mixed.clipping),
      table(mixed.transfer_function, unit, mixed.store->manifest().type, mixed.store->manifest().range) {}

VolumeMix::VolumeMix(std::vector<MixedVolume> volumes, const MixView& view) : view_(view) {
  std::vector<ZonedVolume> zoned;
  for (MixedVolume& mixed : volumes) {
    volumes_.push_back(std::make_unique<Volume>(std::move(mixed), view_));
    const Volume& volume = *volumes_.back();
    zoned.push_back(zonedVolume(volume.mixed.store->manifest(), volume.levels, volume.mixed.transfer_function,
                                volume.table, view_.sampling));
  }
  for (std::vector<SlabZone>& slabs : sharedZones(zoned, view_.view, view_.sampling.level))
    zones_.push_back({std::move(slabs), {}, {}});
  float color_unit = 1;
  for (const std::unique_ptr<Volume>& volume : volumes_)
    color_unit = std::max(color_unit, colorUnitOf(volume->mixed.shading));
  for (Zone& zone : zones_) {
    SlabSharing sharing{false, 0, color_unit};
    for (const SlabZone& slabs : zone.slabs) {
      if (slabs.slabs == 0) continue;
      const FootprintTable own(slabs.sigma_px, slabs.soft_sigma_px);
      sharing.least_taps = std::max(sharing.least_taps, own.taps());
    }
    for (std::size_t v = 0; v < volumes_.size(); ++v) {
      const Volume& volume = *volumes_[v];
      const VolumeLook look{volume.mixed.transfer_function,
                            volume.mixed.shading,
                            view_.view,
                            volume.unit,
                            gradientNoiseOf(volume.mixed.store->manifest(), volume.mixed.transfer_function),
                            view_.sampling.interpolation};
      const bool reaches = zone.slabs[v].slabs > 0;
      zone.frames.push_back(reaches ? zoneFrame(zone.slabs[v], volume.levels, volume.table, look, sharing) : nullptr);
    }
  }
  const PixelRect picture{0, 0, view_.view.size.width, view_.view.size.height};
  for (std::size_t v = 0; v < volumes_.size(); ++v) addBricks(v, picture);
}

void VolumeMix::addBricks(std::size_t volume, const PixelRect& picture) {
  std::set<int> levels;
  for (const Zone& zone : zones_) {
    if (zone.frames[volume]) levels.insert(zone.slabs[volume].level);
  }
  const BrickIndex& index = volumes_[volume]->mixed.store->index();
  for (const int level : levels) {
    const Extent3& lattice = index.lattice(level);
    for (std::int64_t i = 0; i < lattice.count(); ++i) addBrick(volume, {level, brickAt(lattice, i)}, picture);
  }
}

void VolumeMix::addBrick(std::size_t volume, const BrickKey& key, const PixelRect& picture) {
  const StoreReader& store = *volumes_[volume]->mixed.store;
  const FrameLevels& levels = volumes_[volume]->levels;
  const std::int64_t brick_size = store.manifest().brick_size;
  const VoxelBox core = coreBox(key.brick, brick_size, levels.dims(key.level));
  const DepthZones::Depths depths = DepthZones::depthsOf(levels.projector(key.level), core);
  const auto first = std::partition_point(zones_.begin(), zones_.end(), [&](const Zone& zone) {
    return zone.slabs[volume].far + 2 * zone.slabs[volume].thickness < depths.near;
  });
  bool of_frame = false, interesting = false;
  for (auto zone = first; zone != zones_.end(); ++zone) {
    const SlabZone& slabs = zone->slabs[volume];
    if (slabs.near - 2 * slabs.thickness > depths.far) break;
    if (!zone->frames[volume] || slabs.level != key.level || !DepthZones::reaches(depths, slabs)) continue;
    of_frame = true;
    PixelRect rect;
    anyPartIn(*zone->frames[volume], core, brick_size, store.index().at(key), [&](const PixelRect& part) {
      interesting = true;
      const PixelRect seen = intersection(part, picture);
      if (!seen.empty()) rect = aroundBoth(rect, seen);
      return false;  // and on to the next
    });
    if (rect.empty()) continue;
    const auto edge = static_cast<std::uint64_t>(brick_size / kCellSize);
    const std::uint64_t cells = edge * edge * edge * sizeof(SlabCell);
    const std::uint64_t bytes = blockBytes(store.frame(key)) + cells, read = store.readBytes(key);
    reading_bytes_ = std::max(reading_bytes_, read - std::min(read, bytes));
    zone->bricks.push_back({{key, static_cast<int>(volume)}, rect, bytes});
  }
  counts_.bricks += of_frame ? 1 : 0;
  counts_.interesting += interesting ? 1 : 0;
}

std::uint64_t VolumeMix::bricksIn(std::size_t zone, const PixelRect& tile) const {
  const std::vector<Brick>& bricks = zones_[zone].bricks;
  return static_cast<std::uint64_t>(std::count_if(
      bricks.begin(), bricks.end(), [&](const Brick& brick) { return !intersection(brick.rect, tile).empty(); }));
}

std::vector<StoredBrick> VolumeMix::inView(const PixelRect& pixels) const {
  std::set<StoredBrick> out;
  for (const Zone& zone : zones_) {
    for (const Brick& brick : zone.bricks) {
      if (!intersection(brick.rect, pixels).empty()) out.insert(brick.brick);
    }
  }
  return {out.begin(), out.end()};
}

std::uint64_t VolumeMix::bytesFor(std::span<const Brick* const> bricks) const {
  std::uint64_t sum = reading_bytes_;
  for (const Brick* const brick : bricks) sum += brick->bytes;
  return sum;
}

std::uint64_t VolumeMix::mostBytes(std::span<const PixelRect> tiles) const {
  std::uint64_t most = 0;
  std::vector<const Brick*> touching;
  for (const Zone& zone : zones_) {
    for (const PixelRect& tile : tiles) {
      touching.clear();
      for (const Brick& brick : zone.bricks) {
        if (!intersection(brick.rect, tile).empty()) touching.push_back(&brick);
      }
      most = std::max(most, bytesFor(touching));
    }
  }
  return most;
}

std::vector<SplatCounts> VolumeMix::draw(std::size_t zone, std::span<const Brick* const> bricks, const Blocks& blocks,
                                         const std::vector<TilePixels>& tiles, Visibility& visibility,
                                         bool test_samples, float opaque_at,
                                         const std::function<void(std::size_t)>& tile_drawn) {
  const std::vector<std::unique_ptr<SlabFrame>>& owned = zones_[zone].frames;
  std::vector<const SlabFrame*> frames;
  for (const std::unique_ptr<SlabFrame>& frame : owned) frames.push_back(frame.get());
  std::vector<std::vector<SlabCell>> cells(bricks.size());
  parallelFor(bricks.size(), [&](std::size_t i) {
    const Span span(Activity::kCells);
    if (blocks[i]) cells[i] = interestingCells(*frames[static_cast<std::size_t>(bricks[i]->brick.store)], *blocks[i]);
  });
  std::vector<std::vector<SplatCounts>> counts(tiles.size(), std::vector<SplatCounts>(frames.size()));
  parallelFor(tiles.size(), [&](std::size_t t) {
    const Span span(Activity::kTile);
    pool_.lend([&](SweepMemory& memory) {
      std::vector<SweptCell> touching;
      for (const TilePixels& square : squaresOf(tiles[t], view_.sweep_px)) {
        touching.clear();
        for (std::size_t i = 0; i < bricks.size(); ++i) {
          if (intersection(bricks[i]->rect, square.rect).empty()) continue;
          for (const SlabCell& cell : cells[i]) {
            if (!intersection(cell.bounds.rect, square.rect).empty())
              touching.push_back({&cell, blocks[i].get(), static_cast<std::size_t>(bricks[i]->brick.store)});
          }
        }
        sweepTogether(frames, touching, square, visibility, test_samples, opaque_at, memory, counts[t]);
      }
    });
    tile_drawn(t);
  });
  std::vector<SplatCounts> total(frames.size());
  for (const std::vector<SplatCounts>& tile : counts) {
    for (std::size_t v = 0; v < total.size(); ++v) total[v].add(tile[v]);
  }
  return total;
}

}  // namespace kiln
