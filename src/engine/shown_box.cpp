#include "engine/shown_box.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/shared/classifier.h"
#include "grid/voxel_type.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"

namespace kiln {
namespace {

// A cube that is filled with its most opaque value and has a lower alpha is haze: less than 8 steps of an 8-bit pixel.
constexpr double kLeastAlpha = 1.0 / 32;

// Returns the function with all opacities below `least` set to zero. Segments are split where they cross `least`.
TransferFunction withoutHaze(TransferFunction function, double least) {
  for (LabelStyle& style : function.labels) style.opacity = style.opacity < least ? 0 : style.opacity;
  for (IsoSurface& surface : function.surfaces) surface.opacity = surface.opacity < kLeastAlpha ? 0 : surface.opacity;
  std::vector<TransferPoint> points;
  for (TransferPoint point : function.points) {
    const bool shown = point.opacity >= least;
    if (!points.empty() && shown != (points.back().opacity >= least) && point.value > points.back().value) {
      // The pair of points at the crossing is a step from or to zero.
      const TransferPoint& before = points.back();
      const double t = (least - before.opacity) / (point.opacity - before.opacity);
      const double value = std::lerp(before.value, point.value, t);
      points.push_back({value, point.color, shown ? 0 : least});
      points.push_back({value, point.color, shown ? least : 0});
    }
    points.push_back(point);
  }
  for (TransferPoint& point : points) point.opacity = point.opacity < least ? 0 : point.opacity;
  function.points = std::move(points);
  return function;
}

// Decides which ranges of values some function shows.
class ShownValues {
 public:
  ShownValues(const Manifest& manifest, std::span<const TransferFunction> functions, double thickness,
              const Progress& progress) {
    for (const TransferFunction& function : functions) {
      progress.throwIfCancelled("looking for the visible box");
      const double unit = function.unitIn(manifest.geometry().meanSpacing());
      const double least = 1 - std::pow(1 - kLeastAlpha, unit / thickness);
      classifiers_.emplace_back(withoutHaze(function, least), unit, VoxelType::f64, manifest.range);
    }
  }
  bool in(const ValueRange& range) const {
    return !range.empty() && std::any_of(classifiers_.begin(), classifiers_.end(),
                                         [&](const Classifier& c) { return c.interesting(range); });
  }

 private:
  std::vector<Classifier> classifiers_;
};

bool contains(const VoxelBox& outer, const VoxelBox& inner) { return intersection(outer, inner) == inner; }

void include(VoxelBox& box, const VoxelBox& more) { box = box.empty() ? more : bounding(box, more); }

// Returns `box` without the outer layers that lie outside the region.
VoxelBox cutBy(const Clipping& clipping, const ClipRegion& region, const VoxelBox& box) {
  VoxelBox out = clipping.region ? intersection(box, *clipping.region) : box;
  if (region.showsAll() || out.empty()) return out;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool low : {true, false}) {
      // A layer that contains a layer outside is not outside: the deepest outside layer is found by bisection.
      std::int64_t outside = 0, inside = out.hi[axis] - out.lo[axis] + 1;
      while (inside - outside > 1) {
        const std::int64_t depth = outside + (inside - outside) / 2;
        VoxelBox layer = out;
        (low ? layer.hi[axis] : layer.lo[axis]) = low ? out.lo[axis] + depth : out.hi[axis] - depth;
        (region.classify(layer) == ClipRegion::Overlap::kOutside ? outside : inside) = depth;
      }
      (low ? out.lo[axis] : out.hi[axis]) += low ? outside : -outside;
    }
  }
  return out;
}

// Step 1: the box around the sub-bricks that may show something.
VoxelBox boxOfIndex(const BrickedVolume& store, const ShownValues& shown, const ClipRegion& region,
                    const Progress& progress) {
  const std::int64_t size = store.manifest().brick_size;
  const Extent3 lattice = store.index().lattice(0);
  VoxelBox out;
  const auto isNew = [&](const VoxelBox& cube) {
    return !cube.empty() && !contains(out, cube) && region.classify(cube) != ClipRegion::Overlap::kOutside;
  };
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    progress.throwIfCancelled("looking for the visible box");
    const BrickKey key{0, brickAt(lattice, i)};
    const BrickEntry& entry = store.index().at(key);
    const VoxelBox core = coreBox(key.brick, size, store.manifest().geometry().dims);
    if (!isNew(core) || !shown.in(entry.support)) continue;
    if (!entry.sub_ranges) {
      include(out, core);
      continue;
    }
    entry.sub_ranges->any([&](std::size_t sub, const VoxelCoord& at) {
      const VoxelBox cube = subBrickOf(core, size, entry.sub_ranges->along(), at);
      if (isNew(cube) && shown.in(entry.sub_ranges->at(sub, entry.support))) include(out, cube);
      return false;
    });
  }
  return out;
}

// Returns the box, in voxels of the block, of cells that show something inside `within`. A cell is a voxel and its next
// neighbours.
template <class T>
VoxelBox boxOfVoxels(const BrickBlock& block, const ShownValues& shown, const VoxelBox& within) {
  VoxelBox out;
  const T* const values = block.data<T>();
  const std::int64_t steps[] = {0, 1, block.strideY(), block.strideZ()};
  for (std::int64_t z = within.lo.z; z < within.hi.z; ++z) {
    for (std::int64_t y = within.lo.y; y < within.hi.y; ++y) {
      for (std::int64_t x = within.lo.x; x < within.hi.x; ++x) {
        const VoxelBox cell = {{x, y, z}, {x + 1, y + 1, z + 1}};
        if (contains(out, cell)) {
          x = out.hi.x - 1;
          continue;
        }
        ValueRange range;
        for (const std::int64_t step : steps) {
          const std::int64_t voxel = block.offsetOf(cell.lo) + step;
          if (block.shown.all() || block.shown.at(voxel)) range.include(static_cast<double>(values[voxel]));
        }
        if (shown.in(range)) include(out, intersection({{x, y, z}, {x + 2, y + 2, z + 2}}, within));
      }
    }
  }
  return out;
}

// Step 3: moves the faces of `box` inward to the voxels that show something.
void refine(const BrickedVolume& store, const ShownValues& shown, ShownBox& box) {
  const Manifest& manifest = store.manifest();
  int level = 0;
  const int levels = store.index().levels();
  while (level < levels && store.index().lattice(level).count() > 1) ++level;
  if (level == levels) return;
  const BrickKey key{level, {}};
  const BrickEntry& entry = store.index().at(key);
  const BrickBlock block = store.read(key);
  box.files += entry.constant ? 0 : 1;
  box.file_bytes += entry.file_bytes;

  const Extent3 span = manifest.spanOf(level);
  const VoxelBox within = intersection(coarseBox(box.box, span), boxOf(store.level(level).geometry.dims));
  const VoxelBox found =
      withVoxelType(block.type, [&]<class T>(std::type_identity<T>) { return boxOfVoxels<T>(block, shown, within); });
  if (found.empty()) return;
  // A coarse voxel is a mean, in which a thin layer is lost: a face that would move further stays.
  const std::int64_t most = manifest.brick_size / subBricksOf(manifest.brick_size) + manifest.apron;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = found.lo[axis] * span[axis], hi = found.hi[axis] * span[axis];
    if (lo > box.box.lo[axis] && lo - box.box.lo[axis] <= most) box.box.lo[axis] = lo;
    if (hi < box.box.hi[axis] && box.box.hi[axis] - hi <= most) box.box.hi[axis] = hi;
  }
}

}  // namespace

VoxelBox boxOfClip(const VolumeGeometry& volume, Clipping clipping) {
  clipping.part.reset();
  return cutBy(clipping, ClipRegion(clipping, volume), boxOf(volume.dims));
}

ShownBox shownBox(const BrickedVolume& store, std::span<const TransferFunction> functions, const Clipping& clipping,
                  bool read_brick, const Progress& progress) {
  const Manifest& manifest = store.manifest();
  Clipping whole = clipping;
  whole.part.reset();
  const ClipRegion region(whole, manifest.geometry());
  const double cube = static_cast<double>(manifest.brick_size / subBricksOf(manifest.brick_size));
  const ShownValues shown(manifest, functions, cube * manifest.geometry().meanSpacing(), progress);
  ShownBox out{boxOfIndex(store, shown, region, progress)};
  if (read_brick && !out.box.empty()) refine(store, shown, out);
  out.box = cutBy(whole, region, out.box);
  return out;
}

}  // namespace kiln
