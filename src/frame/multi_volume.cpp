#include "frame/multi_volume.h"

#include <algorithm>
#include <set>

#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "engine/pixel/cast_cells.h"
#include "engine/pixel/composite_slabs.h"
#include "traverse/depth_zones.h"

namespace kiln {
namespace {

double unitOf(const MixedVolume& volume) {
  return volume.transfer_function.unitIn(volume.store->manifest().geometry().meanSpacing());
}

}  // namespace

MultiVolume::Volume::Volume(MixedVolume the_mixed, const MixView& view)
    : mixed(std::move(the_mixed)),
      unit(unitOf(mixed)),
      levels(mixed.store->manifest(), view.sampling.level, view.view, view.area, mixed.clipping),
      table(mixed.transfer_function, unit, mixed.store->manifest().type, mixed.store->manifest().range) {}

MultiVolume::MultiVolume(std::vector<MixedVolume> volumes, const MixView& view) : view_(view) {
  std::vector<ZonedVolume> zoned;
  for (MixedVolume& mixed : volumes) {
    volumes_.push_back(std::make_unique<Volume>(std::move(mixed), view_));
    const Volume& volume = *volumes_.back();
    zoned.push_back(zonedVolume(volume.mixed.store->manifest(), volume.levels, view_.sampling));
  }
  for (std::vector<SlabZone>& slabs : sharedZones(zoned, view_.view, view_.sampling.level))
    zones_.push_back({std::move(slabs), {}, {}, {}});
  for (Zone& zone : zones_) {
    for (std::size_t v = 0; v < volumes_.size(); ++v) {
      const Volume& volume = *volumes_[v];
      const VolumeAppearance look{volume.mixed.transfer_function,
                                  volume.mixed.shading,
                                  view_.view,
                                  volume.unit,
                                  gradientNoiseOf(volume.mixed.store->manifest(), volume.mixed.transfer_function),
                                  view_.sampling.interpolation};
      const bool reaches = zone.slabs[v].slabs > 0;
      zone.frames.push_back(reaches ? zoneFrame(zone.slabs[v], volume.levels, volume.table, look) : nullptr);
    }
  }
  for (std::size_t v = 0; v < volumes_.size(); ++v) addRays(v);
  const PixelRect picture{0, 0, view_.view.size.width, view_.view.size.height};
  for (std::size_t v = 0; v < volumes_.size(); ++v) addBricks(v, picture);
}

void MultiVolume::addRays(std::size_t volume) {
  const FrameLevels& levels = volumes_[volume]->levels;
  std::vector<SlabZone> zones;
  for (const Zone& zone : zones_) zones.push_back(zone.slabs[volume]);
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const int level = zones[i].level;
    zones_[i].rays.emplace_back(zones, i, levels.projector(level), levels.dims(level), levels.endVoxels(level),
                                view_.sampling.quincunx);
  }
}

void MultiVolume::addBricks(std::size_t volume, const PixelRect& picture) {
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

void MultiVolume::addBrick(std::size_t volume, const BrickKey& key, const PixelRect& picture) {
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

std::uint64_t MultiVolume::bricksIn(std::size_t zone, const PixelRect& tile) const {
  const std::vector<Brick>& bricks = zones_[zone].bricks;
  return static_cast<std::uint64_t>(std::count_if(
      bricks.begin(), bricks.end(), [&](const Brick& brick) { return !intersection(brick.rect, tile).empty(); }));
}

std::vector<StoredBrick> MultiVolume::inView(const PixelRect& pixels) const {
  std::set<StoredBrick> out;
  for (const Zone& zone : zones_) {
    for (const Brick& brick : zone.bricks) {
      if (!intersection(brick.rect, pixels).empty()) out.insert(brick.brick);
    }
  }
  return {out.begin(), out.end()};
}

std::uint64_t MultiVolume::bytesFor(std::span<const Brick* const> bricks) const {
  std::uint64_t sum = reading_bytes_;
  for (const Brick* const brick : bricks) sum += brick->bytes;
  return sum;
}

std::uint64_t MultiVolume::mostBytes(std::span<const PixelRect> tiles) const {
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

std::vector<DrawCounts> MultiVolume::draw(std::size_t zone, std::span<const Brick* const> bricks, const Blocks& blocks,
                                          const std::vector<TilePixels>& tiles, Visibility& visibility, float opaque_at,
                                          const std::function<void(std::size_t)>& tile_drawn) {
  const Zone& of = zones_[zone];
  Cells cells(bricks.size());
  parallelFor(bricks.size(), [&](std::size_t i) {
    const ProfileScope span(Activity::kCells);
    if (blocks[i]) cells[i] = visibleCells(*of.frames[static_cast<std::size_t>(bricks[i]->brick.store)], *blocks[i]);
  });
  const ZoneBricks drawn{of, bricks, blocks, cells};
  std::vector<std::vector<DrawCounts>> counts(tiles.size(), std::vector<DrawCounts>(volumes_.size()));
  parallelFor(tiles.size(), [&](std::size_t t) {
    const ProfileScope span(Activity::kTile);
    drawTile(drawn, tiles[t], visibility, opaque_at, counts[t]);
    tile_drawn(t);
  });
  std::vector<DrawCounts> total(volumes_.size());
  for (const std::vector<DrawCounts>& tile : counts) {
    for (std::size_t v = 0; v < total.size(); ++v) total[v].add(tile[v]);
  }
  return total;
}

// Sums are added volume by volume, so that no bit of them depends on the order of bricks.
void MultiVolume::drawTile(const ZoneBricks& drawn, const TilePixels& tile, Visibility& visibility, float opaque_at,
                           std::span<DrawCounts> counts) {
  const Zone& zone = drawn.zone;
  const int slabs = std::max_element(zone.slabs.begin(), zone.slabs.end(), [](const SlabZone& a, const SlabZone& b) {
                      return a.slabs < b.slabs;
                    })->slabs;
  sums_.lend([&](SlabSums& sums) {
    for (const TilePixels& square : squaresOf(tile)) {
      if (visibility.hidden(square.rect)) continue;
      sums.reset(square.rect, slabs, square.aovs.normal[0] != nullptr);
      for (std::size_t v = 0; v < volumes_.size(); ++v) {
        for (std::size_t i = 0; i < drawn.bricks.size(); ++i) {
          const Brick& brick = *drawn.bricks[i];
          if (static_cast<std::size_t>(brick.brick.store) != v || !drawn.blocks[i]) continue;
          if (intersection(brick.rect, square.rect).empty()) continue;
          sumCells(zone.rays[v], *zone.frames[v], *drawn.blocks[i], drawn.cells[i], square, visibility, sums,
                   counts[v]);
        }
      }
      compositeSlabs(sums, zone.slabs.front(), zone.rays.front(), square, opaque_at, visibility);
    }
  });
}

}  // namespace kiln
