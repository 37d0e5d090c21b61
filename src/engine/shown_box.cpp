#include "engine/shown_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "engine/shown_depths.h"
#include "engine/shown_outline.h"
#include "engine/side_views.h"
#include "grid/voxel_type.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"

namespace kiln {
namespace {

// A cube that is filled with its most opaque value and has a lower alpha shows nothing by itself. Matter that is faint
// and thick shows in the views along the axes.
constexpr double kLeastAlpha = 1.0 / 32;

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

// Returns the opacity that the bound of a cube's values may have along `length`; 0 if too little shows. unit: world.
double opacityIn(const ShownDepths& shown, const ValueRange& range, double length) {
  const double alpha = -std::expm1(-shown.depth(range, length));
  return alpha < kLeastAlpha ? 0 : alpha;
}

// Calls each(cube, range) for the cubes of the index that `wanted` admits inside the clip region. A brick that `wanted`
// refuses is skipped whole.
template <class Wanted, class Each>
void forCubes(const BrickedVolume& store, const ClipRegion& region, const Progress& progress, Wanted&& wanted,
              Each&& each) {
  const std::int64_t size = store.manifest().brick_size;
  const Extent3 lattice = store.index().lattice(0);
  const auto admitted = [&](const VoxelBox& cube, const ValueRange& range) {
    return !cube.empty() && wanted(cube, range) && region.classify(cube) != ClipRegion::Overlap::kOutside;
  };
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    progress.throwIfCancelled("looking for the visible box");
    const BrickKey key{0, brickAt(lattice, i)};
    const BrickEntry& entry = store.index().at(key);
    const VoxelBox core = coreBox(key.brick, size, store.manifest().geometry().dims);
    if (!admitted(core, entry.support)) continue;
    if (!entry.sub_ranges) {
      each(core, entry.support);
      continue;
    }
    entry.sub_ranges->any([&](std::size_t sub, const VoxelCoord& at) {
      const VoxelBox cube = subBrickOf(core, size, entry.sub_ranges->along(), at);
      const ValueRange range = entry.sub_ranges->at(sub, entry.support);
      if (admitted(cube, range)) each(cube, range);
      return false;
    });
  }
}

// The box around all cubes whose values give `length` at least a depth.
VoxelBox boxOfIndex(const BrickedVolume& store, const ShownDepths& shown, const ClipRegion& region, double length,
                    double least_depth, const Progress& progress) {
  VoxelBox out;
  const auto wanted = [&](const VoxelBox& cube, const ValueRange& range) {
    return !contains(out, cube) && shown.depth(range, length) >= least_depth;
  };
  forCubes(store, region, progress, wanted, [&](const VoxelBox& cube, const ValueRange&) { include(out, cube); });
  return out;
}

// The box beside which not even the volume's whole diagonal shows anything of a cube's values. Closer than the voxels
// of a level whose voxels are larger than cubes.
VoxelBox boxBesideNothing(const BrickedVolume& store, const ShownDepths& shown, const ClipRegion& region,
                          const Progress& progress) {
  const auto corners = store.manifest().geometry().corners();
  double diagonal = 0;
  for (const glm::dvec3& a : corners) {
    for (const glm::dvec3& b : corners) diagonal = std::max(diagonal, glm::distance(a, b));
  }
  return boxOfIndex(store, shown, region, diagonal, kLeastColumn, progress);
}

// Voxels of a level that a mask leaves.
class ShownOfLevel {
 public:
  explicit ShownOfLevel(const Extent3& dims) : dims_(dims) {}

  void add(const BrickBlock& block) {
    if (block.shown.all()) return;
    if (hidden_.empty()) hidden_.resize(static_cast<std::size_t>(dims_.count()));
    forEachCoord(block.core, [&](const VoxelCoord& v) {
      if (!block.shown.at(block.offsetOf(v))) hidden_[placeOf(v)] = true;
    });
  }
  bool any(const VoxelBox& box) const {
    bool out = hidden_.empty();
    if (!out) forEachCoord(box, [&](const VoxelCoord& v) { out = out || !hidden_[placeOf(v)]; });
    return out;
  }

 private:
  std::size_t placeOf(const VoxelCoord& v) const {
    return static_cast<std::size_t>((v.z * dims_.y + v.y) * dims_.x + v.x);
  }

  const Extent3 dims_;
  std::vector<bool> hidden_;  // empty: none
};

// Adds the cells of a brick to the views. A cell is a voxel and its next neighbours.
class CellsOfBrick {
 public:
  CellsOfBrick(const BrickBlock& block, const ShownDepths& shown, const ClipRegion& region, const VolumeGeometry& level,
               const std::optional<Section>& section)
      : block_(block), shown_(shown), region_(region), lo_(block.core.lo), dims_(block.core.extent()) {
    const glm::dvec3 spacing = level.spacing();
    spacing_ = {spacing.x, spacing.y, spacing.z};
    faces_ = section && section->opacity > 0 && !region.showsAll();
    values_on_faces_ = faces_ && !section->color_map.empty();
  }

  void addTo(SideViews& views) {
    Numbers near = numbersOf(0), far;
    for (std::int64_t z = 0; z < dims_.z; ++z, std::swap(near, far)) {
      far = numbersOf(z + 1);
      for (std::int64_t y = 0; y < dims_.y; ++y) addRow(near, far, y, z, views);
    }
  }

 private:
  // Numbers of the values of a slice, with a column and a row more than the brick; ShownDepths::kNone: missing,
  // hidden. Surfaces lie between shown and hidden values, too.
  using Numbers = std::vector<int>;

  Numbers numbersOf(std::int64_t z) const {
    Numbers out;
    out.reserve(static_cast<std::size_t>((dims_.x + 1) * (dims_.y + 1)));
    withVoxelType(block_.type, [&]<class T>(std::type_identity<T>) {
      for (std::int64_t y = 0; y <= dims_.y; ++y) {
        const std::int64_t row = block_.offsetOf({lo_.x, lo_.y + y, lo_.z + z});
        for (std::int64_t x = 0; x <= dims_.x; ++x) {
          const bool hidden = !shown_.ofSurfaces() && !block_.shown.all() && !block_.shown.at(row + x);
          out.push_back(hidden ? ShownDepths::kNone : shown_.binOf(static_cast<double>(block_.data<T>()[row + x])));
        }
      }
    });
    return out;
  }

  void addRow(const Numbers& near, const Numbers& far, std::int64_t y, std::int64_t z, SideViews& views) const {
    const auto row = static_cast<std::size_t>(y * (dims_.x + 1)), next = row + static_cast<std::size_t>(dims_.x + 1);
    for (std::int64_t x = 0; x < dims_.x; ++x) {
      const auto i = static_cast<std::size_t>(x);
      int first = near[row + i], last = first;
      if (!shown_.ofLabels()) {
        // As numbers without a sign, missing values are above all others.
        auto least = static_cast<unsigned>(first);
        for (const Numbers* const slice : {&near, &far}) {
          for (const std::size_t at : {row + i, row + i + 1, next + i, next + i + 1}) {
            least = std::min(least, static_cast<unsigned>((*slice)[at]));
            last = std::max(last, (*slice)[at]);
          }
        }
        first = static_cast<int>(least);
      }
      if (last != ShownDepths::kNone) addCell({lo_.x + x, lo_.y + y, lo_.z + z}, first, last, views);
    }
  }

  void addCell(const VoxelCoord& cell, int first, int last, SideViews& views) const {
    if (!values_on_faces_ && !(shown_.depth(first, last, 1) > 0)) return;
    const VoxelBox voxels = {cell, {cell.x + 2, cell.y + 2, cell.z + 2}};
    if (shown_.ofSurfaces() && !block_.shown.any(voxels)) return;
    if (!region_.showsAll() && region_.classify(voxels) == ClipRegion::Overlap::kOutside) return;
    // A face is opaque.
    constexpr double kOpaque = 10;
    const bool on_face = faces_ && isCut(cell);
    std::array<double, 3> depth;
    for (std::size_t axis = 0; axis < 3; ++axis)
      depth[axis] = on_face ? kOpaque : shown_.depth(first, last, spacing_[axis]);
    if (depth[0] > 0) views.add(cell, depth);
  }

  // True if some corner is outside the region, and some inside.
  bool isCut(const VoxelCoord& cell) const {
    int inside = 0;
    for (int corner = 0; corner < 8; ++corner)
      inside += region_.contains(glm::dvec3(cell.x + (corner & 1), cell.y + (corner >> 1 & 1), cell.z + (corner >> 2)));
    return inside > 0 && inside < 8;
  }

  const BrickBlock& block_;
  const ShownDepths& shown_;
  const ClipRegion& region_;
  const VoxelCoord lo_;
  const Extent3 dims_;
  std::array<double, 3> spacing_;
  bool faces_, values_on_faces_;
};

// Returns the voxels whose values the range of a cube of the index holds, possibly beyond the volume.
VoxelBox rangedVoxels(const VoxelBox& cube, const Manifest& manifest) {
  const auto reach = [&](std::int64_t at) { return at % manifest.brick_size == 0 ? manifest.apron : kSubBrickReach; };
  VoxelBox out = cube;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] -= reach(cube.lo[axis]);
    out.hi[axis] += reach(cube.hi[axis]);
  }
  return out;
}

// Step 2: adds what the voxels of a coarser level hide. A cube at the border of an object reaches beyond the object,
// and counts only if the level shows nothing of the cube.
void addThinCubes(const BrickedVolume& store, int level, const ShownOfLevel& unmasked, const ShownDepths& shown,
                  const ClipRegion& region, const Progress& progress, SideViews& views) {
  const Manifest& manifest = store.manifest();
  const Extent3 span = manifest.spanOf(level);
  const double most = static_cast<double>(std::max({span.x, span.y, span.z}));
  const double length = most * manifest.geometry().meanSpacing();
  const auto cube = static_cast<double>(manifest.brick_size / subBricksOf(manifest.brick_size));
  // A line of one voxel through a cube covers this part of the pixels that hold the cube.
  const double line = std::min(1.0, cube / most * cube / most) / cube;
  const auto wanted = [&](const VoxelBox&, const ValueRange& range) { return opacityIn(shown, range, length) > 0; };
  std::vector<std::pair<VoxelBox, double>> found;
  forCubes(store, region, progress, wanted, [&](const VoxelBox& box, const ValueRange& range) {
    const VoxelBox ranged = intersection(rangedVoxels(box, manifest), boxOf(manifest.geometry().dims));
    const VoxelBox coarse = coarseBox(box, span);
    // A cell reaches into the next voxels.
    if (!views.showsIn(dilated(coarseBox(ranged, span), 1)) && unmasked.any(coarse))
      found.emplace_back(coarse, line * opacityIn(shown, range, length));
  });
  for (const auto& [box, opacity] : found) views.addThin(box, opacity);
}

// A box of voxels of a coarser level in voxels of level 0.
VoxelBox fineBox(const VoxelBox& coarse, const Extent3& span, const Extent3& dims) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = coarse.lo[axis] * span[axis];
    out.hi[axis] = std::min(coarse.hi[axis] * span[axis], dims[axis]);
  }
  return out;
}

// What the views of a level show.
struct SeenBoxes {
  VoxelBox box;                // around all
  std::vector<VoxelBox> rows;  // of cells
};

SeenBoxes boxesOfLevel(const BrickedVolume& store, int level, const ShownDepths& shown, const Clipping& clipping,
                       const ClipRegion& region, const Progress& progress, ShownBox& reads) {
  const Manifest& manifest = store.manifest();
  const VolumeGeometry& geometry = store.level(level).geometry;
  const Extent3 span = manifest.spanOf(level);
  SideViews views(geometry.dims);
  const ClipRegion of_level(clipping, manifest.geometry(), span);
  ShownOfLevel unmasked(geometry.dims);
  const Extent3 lattice = store.index().lattice(level);
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    progress.throwIfCancelled("looking for the visible box");
    const BrickKey key{level, brickAt(lattice, i)};
    const BrickEntry& entry = store.index().at(key);
    const BrickBlock block = store.read(key);
    CellsOfBrick(block, shown, of_level, geometry, clipping.section).addTo(views);
    unmasked.add(block);
    reads.files += entry.constant ? 0 : 1;
    reads.file_bytes += entry.file_bytes;
  }
  // A range of labels holds labels that are nowhere in the cube. The level of the most frequent of 2³ labels lacks only
  // what is one voxel thin.
  const bool halved = std::max({span.x, span.y, span.z}) <= 2;
  if (level > 0 && !(shown.ofLabels() && halved)) addThinCubes(store, level, unmasked, shown, region, progress, views);
  const Extent3& dims = manifest.geometry().dims;
  SeenBoxes out{fineBox(views.box(), span, dims), views.rows()};
  // A part that counts in the view along an axis alone has no place along the axis in the box of the views.
  for (VoxelBox& row : out.rows) row = fineBox(row, span, dims), include(out.box, row);
  // A section shows other values, too.
  const bool closer = level > 0 && !clipping.section && !out.box.empty();
  if (closer) out.box = intersection(out.box, boxBesideNothing(store, shown, region, progress));
  return out;
}

}  // namespace

VoxelBox boxOfClip(const VolumeGeometry& volume, Clipping clipping) {
  clipping.part.reset();
  return cutBy(clipping, ClipRegion(clipping, volume), boxOf(volume.dims));
}

ShownBox shownBox(const BrickedVolume& store, std::span<const TransferFunction> functions, const Clipping& clipping,
                  bool read_level, const Progress& progress) {
  const Manifest& manifest = store.manifest();
  Clipping whole = clipping;
  whole.part.reset();
  const ClipRegion region(whole, manifest.geometry());
  const double spacing = manifest.geometry().meanSpacing();
  const ShownDepths shown(functions, spacing, manifest.range, progress);
  ShownBox out;
  const std::optional<int> level = read_level ? store.overviewLevel() : std::nullopt;
  std::vector<VoxelBox> parts;
  if (level) {
    SeenBoxes seen = boxesOfLevel(store, *level, shown, whole, region, progress, out);
    out.box = seen.box, parts = std::move(seen.rows);
  } else {
    const auto cube = static_cast<double>(manifest.brick_size / subBricksOf(manifest.brick_size));
    out.box = boxOfIndex(store, shown, region, cube * spacing, -std::log1p(-kLeastAlpha), progress);
  }
  out.box = cutBy(whole, region, out.box);
  for (VoxelBox& part : parts) part = intersection(part, out.box);
  std::erase_if(parts, [](const VoxelBox& part) { return part.empty(); });
  if (parts.empty() && !out.box.empty()) parts.push_back(out.box);
  out.outline = outlineOf(parts, manifest.geometry());
  return out;
}

}  // namespace kiln
