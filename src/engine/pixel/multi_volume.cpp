#include "engine/pixel/multi_volume.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/thread/profile_scope.h"
#include "engine/pixel/composite_slabs.h"
#include "engine/pixel/pixel_engine.h"
#include "engine/pixel/ray_caster.h"
#include "store/codec/brick_codec.h"
#include "traverse/depth_zones.h"

namespace kiln {

// The bricks of all volumes in one zone. In each square, sums are added volume by volume, so that no bit of them
// depends on the order of bricks.
class MultiVolume::ZoneEngine final : public Engine {
 public:
  ZoneEngine(const Zone& zone, MemoryPool<SlabSums>& sums) : zone_(zone), sums_(sums) {
    for (const SlabZone& slabs : zone.slabs) slabs_ = std::max(slabs_, slabs.slabs);
    for (const std::unique_ptr<SlabContext>& context : zone.contexts)
      exact_ = exact_ || (context && (context->look().surfaces || context->look().faces != nullptr));
  }

  std::unique_ptr<const PreparedBrick> prepare(const BrickToDraw& brick) const override {
    const ProfileScope span(Activity::kCells);
    const auto volume = static_cast<std::size_t>(brick.brick.store);
    return std::make_unique<Prepared>(brick, visibleCells(*zone_.contexts[volume], *brick.block));
  }

  void draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) override {
    sums_.lend([&](SlabSums& sums) {
      forEachSquare(target.pixels.rect, [&](const PixelRect& square) {
        if (!target.visibility.hidden(square)) drawSquare(target.pixels.of(square), bricks, target, sums);
      });
    });
  }

  std::uint64_t scratchBytes() const override { return sums_.bytes(); }

 private:
  struct Prepared final : PreparedBrick {
    Prepared(BrickToDraw the_due, std::vector<SlabCell> the_cells)
        : due(std::move(the_due)), cells(std::move(the_cells)) {}
    const BrickToDraw due;
    const std::vector<SlabCell> cells;
  };

  void drawSquare(const TilePixels& square, std::span<const PreparedBrick* const> bricks, const TileTarget& target,
                  SlabSums& sums) const {
    sums.reset(square.rect, slabs_, keepsLayers(square));
    for (std::size_t volume = 0; volume < zone_.contexts.size(); ++volume)
      addVolume(volume, bricks, square, target, sums);
    if (square.extinction != nullptr)
      addExtinction(sums, *square.extinction);
    else
      compositeSlabs(sums, zone_.slabs.front(), zone_.rays.front(), square, target.opacity_threshold, exact_,
                     target.visibility);
  }

  bool keepsLayers(const TilePixels& square) const {
    const bool has_layers = square.aovs.any() || square.shadows != nullptr || square.deep != nullptr;
    return square.aovs.normal[0] != nullptr || (exact_ && has_layers);
  }

  void addVolume(std::size_t volume, std::span<const PreparedBrick* const> bricks, const TilePixels& square,
                 const TileTarget& target, SlabSums& sums) const {
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      const auto& brick = static_cast<const Prepared&>(*bricks[i]);
      if (static_cast<std::size_t>(brick.due.brick.store) != volume) continue;
      if (intersection(brick.due.rect, square.rect).empty()) continue;
      sumCells(zone_.rays[volume], *zone_.contexts[volume], *brick.due.block, brick.cells, square, target.visibility,
               sums, target.counts[i]);
    }
  }

  // Adds the optical depths of a square's slabs to the lattice. A slab's depth is divided between the cells that the
  // slab meets, by its thickness in each: else a cell that meets one more slab than the next would be darker.
  void addExtinction(const SlabSums& sums, ExtinctionLattice& lattice) const {
    const SlabZone& zone = zone_.slabs.front();
    const PixelRect& rect = sums.rect();
    for (int slab = 0; slab < sums.slabs(); ++slab) {
      const double near = lattice.placeAlong(zone.near + slab * zone.thickness);
      const double far = lattice.placeAlong(zone.near + (slab + 1) * zone.thickness);
      for (int cell = static_cast<int>(std::floor(near)); cell < far; ++cell) {
        const double inside = std::min<double>(cell + 1, far) - std::max<double>(cell, near);
        const auto share = static_cast<float>(inside / (far - near));
        for (int row = 0; row < rect.height(); ++row) {
          if (!sums.has(slab, row)) continue;
          const float* const light = sums.lightRow(slab, row);
          for (int x = 0; x < rect.width(); ++x)
            if (const float depth = light[4 * x + 3]; depth > 0)
              lattice.add(rect.x0 + x, rect.y0 + row, cell, share * depth);
        }
      }
    }
  }

  const Zone& zone_;
  MemoryPool<SlabSums>& sums_;
  int slabs_ = 0;       // the most of a volume
  bool exact_ = false;  // samples have places of their own in slabs
};

MultiVolume::Volume::Volume(MixedVolume the_mixed, const MixView& view)
    : mixed(std::move(the_mixed)),
      appearance(mixed.store->manifest(), mixed.transfer_function, mixed.shading, view.view,
                 view.sampling.interpolation, view.illumination),
      levels(mixed.store->manifest(), view.sampling.level, view.view, view.area, mixed.clipping),
      table(mixed.transfer_function, appearance.unit, mixed.store->manifest().type, mixed.store->manifest().range) {
  appearance.colors = mixed.colors.get();
  colors = colorTable(appearance);
  if (mixed.clipping.section) appearance.section = &*mixed.clipping.section;
  faces = cutFacesOf(appearance.section, mixed.store->manifest(), levels, table);
}

MultiVolume::~MultiVolume() = default;

EngineMemory MultiVolume::memory(std::int64_t brick_size, bool layers) {
  // A brick is in the lists of two or three zones, and in two sets of drawn bricks.
  constexpr std::uint64_t kStoredBytes = 4 * sizeof(Brick) + 2 * 64;
  EngineMemory out = PixelEngine::memory(brick_size);
  out.stored_brick = kStoredBytes;
  out.thread += SlabSums::bytesFor(layers);
  return out;
}

Engine& MultiVolume::engine(std::size_t zone) { return *zones_[zone].engine; }

MultiVolume::MultiVolume(std::vector<MixedVolume> volumes, const MixView& view) : view_(view) {
  std::vector<ZonedVolume> zoned;
  for (MixedVolume& mixed : volumes) {
    volumes_.push_back(std::make_unique<Volume>(std::move(mixed), view_));
    const Volume& volume = *volumes_.back();
    zoned.push_back(zonedVolume(volume.mixed.store->manifest(), volume.levels, view_.sampling));
  }
  for (std::vector<SlabZone>& slabs : sharedZones(zoned, view_.view, view_.sampling.level))
    zones_.push_back({std::move(slabs), {}, {}, {}, nullptr});
  for (Zone& zone : zones_) {
    for (std::size_t v = 0; v < volumes_.size(); ++v) {
      const Volume& volume = *volumes_[v];
      const bool reaches = zone.slabs[v].slabs > 0;
      zone.contexts.push_back(reaches ? zoneContext(zone.slabs[v], volume.levels,
                                                    tablesOf(volume.table, volume.colors, volume.faces.get()),
                                                    volume.appearance)
                                      : nullptr);
    }
  }
  for (std::size_t v = 0; v < volumes_.size(); ++v) addRays(v);
  const PixelRect picture{0, 0, view_.view.size.width, view_.view.size.height};
  for (std::size_t v = 0; v < volumes_.size(); ++v) addBricks(v, picture);
  for (Zone& zone : zones_) zone.engine = std::make_unique<ZoneEngine>(zone, sums_);
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
    if (zone.contexts[volume]) levels.insert(zone.slabs[volume].level);
  }
  const BrickIndex& index = volumes_[volume]->mixed.store->index();
  for (const int level : levels) {
    const Extent3& lattice = index.lattice(level);
    for (std::int64_t i = 0; i < lattice.count(); ++i) addBrick(volume, {level, brickAt(lattice, i)}, picture);
  }
}

void MultiVolume::addBrick(std::size_t volume, const BrickKey& key, const PixelRect& picture) {
  const BrickedVolume& store = *volumes_[volume]->mixed.store;
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
    if (slabs.overlapNear() - 2 * slabs.thickness > depths.far) break;
    if (!zone->contexts[volume] || slabs.level != key.level || !DepthZones::reaches(depths, slabs)) continue;
    of_frame = true;
    PixelRect rect;
    anyPartIn(*zone->contexts[volume], core, brick_size, store.index().at(key), [&](const PixelRect& part) {
      interesting = true;
      const PixelRect seen = intersection(part, picture);
      if (!seen.empty()) rect = aroundBoth(rect, seen);
      return false;  // and on to the next
    });
    if (rect.empty()) continue;
    const auto edge = static_cast<std::uint64_t>(brick_size / kCellSize);
    const std::uint64_t cells = edge * edge * edge * sizeof(SlabCell);
    const std::uint64_t block = store.blockBytes(key), read = store.readBytes(key);
    reading_bytes_ = std::max(reading_bytes_, read - std::min(read, block));
    zone->bricks.push_back({{key, static_cast<int>(volume)}, rect, block, cells});
  }
  counts_.bricks += of_frame ? 1 : 0;
  counts_.interesting += interesting ? 1 : 0;
  counts_.masked += of_frame && store.index().at(key).masked ? 1 : 0;
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
  std::uint64_t sum = reading_bytes_ + cellBytesFor(bricks);
  for (const Brick* const brick : bricks) sum += brick->block_bytes;
  return sum;
}

std::uint64_t MultiVolume::cellBytesFor(std::span<const Brick* const> bricks) {
  std::uint64_t sum = 0;
  for (const Brick* const brick : bricks) sum += brick->cell_bytes;
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

}  // namespace kiln
