// Voxels of bricks as two grids of a renderer: `density`, the extinction of a transfer function per world unit, and
// `Cd`, its colour in linear light. The voxels that the function shows are active, in `Cd` with their neighbours.
#pragma once

#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "export/vdb/brick_voxels.h"
#include "export/vdb/color_border.h"
#include "export/vdb/export_vdb.h"
#include "export/vdb/grid_placement.h"

namespace kiln {

template <class T>
class BakedFiller {
 public:
  struct Baked {
    float density = 0;
    openvdb::Vec3f color{0};
  };

  /// Upper bound of a voxel in the leaves of both grids, and the table of types of 8 and 16 bits. unit: bytes.
  static constexpr std::uint64_t kVoxelBytes = sizeof(Baked) + 2,
                                 kFixedBytes = sizeof(T) <= 2 ? sizeof(Baked) << (8 * sizeof(T)) : 0;
  /// Voxels by which a grid reaches beyond the bricks.
  static constexpr int kReach = 1;

  /// requires: the function has a unit of length.
  BakedFiller(const TransferFunction& function, VdbType type, const GridPlacement& place)
      : function_(function),
        type_(type),
        place_(place),
        density_(newGrid<openvdb::FloatGrid>(0)),
        color_(newGrid<openvdb::Vec3SGrid>(openvdb::Vec3f(0))) {
    density_->setName("density");
    density_->setGridClass(openvdb::GRID_FOG_VOLUME);
    color_->setName("Cd");
    for (const openvdb::GridBase::Ptr& grid : grids()) {
      grid->setTransform(transformOf(place.world_from_grid));
      grid->setSaveFloatAsHalf(type == VdbType::kHalf);
    }
    if constexpr (sizeof(T) <= 2) {
      using Limits = std::numeric_limits<T>;
      for (int value = Limits::min(); value <= Limits::max(); ++value) table_.push_back(evaluated(value));
    }
  }

  bool holds(double constant) const { return of(static_cast<T>(constant)).density != 0; }

  void fill(const VoxelBox& box, double constant) {
    const Baked baked = of(static_cast<T>(constant));
    if (baked.density == 0) return;
    largest_density_ = std::max(largest_density_, baked.density);
    const openvdb::CoordBBox all(place_.of(box.lo), place_.of({box.hi.x - 1, box.hi.y - 1, box.hi.z - 1}));
    density_->sparseFill(all, baked.density, true);
    color_->sparseFill(all, baked.color, true);
  }

  void take(const BrickBlock& block, const VoxelBox& part) {
    auto densities = density_->getAccessor();
    auto colors = color_->getAccessor();
    forEachVoxel<T>(block, part, [&](const VoxelCoord& at, T voxel) {
      const Baked baked = of(voxel);
      if (baked.density == 0) return;
      largest_density_ = std::max(largest_density_, baked.density);
      densities.setValueOn(place_.of(at), baked.density);
      colors.setValueOn(place_.of(at), baked.color);
    });
  }

  std::uint64_t treeBytes() const { return density_->memUsage() + color_->memUsage(); }

  /// Memory that `finish` adds. unit: bytes.
  std::uint64_t finishBytes() {
    density_->pruneGrid(0);
    color_->pruneGrid(0);
    border_.emplace(*color_);
    return border_->bytes();
  }
  /// requires: finishBytes was called behind the last voxel, if there is any.
  openvdb::GridPtrVec finish() {
    if (border_) border_->fill(*color_);
    return grids();
  }
  /// Infinite if the file cannot hold a density; else 0.
  double largestError() const {
    const bool too_large =
        type_ == VdbType::kHalf ? openvdb::math::half(largest_density_).isInfinity() : std::isinf(largest_density_);
    return too_large ? std::numeric_limits<double>::infinity() : 0;
  }

 private:
  openvdb::GridPtrVec grids() const { return {density_, color_}; }
  Baked evaluated(double value) const {
    const Classified seen = function_.at(value);
    if (!(seen.opacity > 0)) return {};
    return {static_cast<float>(extinctionOf(seen.opacity, function_.unit)),
            openvdb::Vec3f(openvdb::Vec3d(seen.color.r, seen.color.g, seen.color.b))};
  }
  Baked of(T voxel) const {
    if constexpr (sizeof(T) <= 2)
      return table_[static_cast<std::size_t>(voxel - std::numeric_limits<T>::min())];
    else
      return evaluated(static_cast<double>(voxel));
  }

  const TransferFunction& function_;
  VdbType type_;
  const GridPlacement& place_;
  openvdb::FloatGrid::Ptr density_;
  openvdb::Vec3SGrid::Ptr color_;
  std::optional<ColorBorder> border_;
  float largest_density_ = 0;
  std::vector<Baked> table_;  // of types of 8 and 16 bits
};

}  // namespace kiln
