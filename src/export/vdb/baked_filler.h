// Voxels of bricks as two grids of a renderer: `density`, the extinction of a transfer function per world unit, and
// `Cd`, its colour in linear light. Active are the voxels that the function shows.
#pragma once

#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "export/vdb/export_vdb.h"
#include "export/vdb/grid_placement.h"
#include "store/codec/brick_block.h"

namespace kiln {

template <class T>
class BakedFiller {
 public:
  /// requires: the function has a unit of length.
  BakedFiller(const TransferFunction& function, VdbType type, const GridPlacement& place, std::uint64_t memory_bytes)
      : memory_bytes_(memory_bytes - std::min(memory_bytes, kTableBytes)),
        function_(function),
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
    const openvdb::CoordBBox all(place_.of(box.lo), place_.of({box.hi.x - 1, box.hi.y - 1, box.hi.z - 1}));
    density_->sparseFill(all, baked.density, true);
    color_->sparseFill(all, baked.color, true);
  }

  void take(const BrickBlock& block, const VoxelBox& part) {
    const T* const voxels = block.data<T>();
    auto densities = density_->getAccessor();
    auto colors = color_->getAccessor();
    for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
        const T* const row = voxels + block.offsetOf({part.lo.x, y, z});
        for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
          const Baked baked = of(row[x - part.lo.x]);
          if (baked.density == 0) continue;
          densities.setValueOn(place_.of({x, y, z}), baked.density);
          colors.setValueOn(place_.of({x, y, z}), baked.color);
        }
      }
    }
  }

  bool charge(const VoxelBox& part, std::uint64_t read_bytes) {
    const std::uint64_t needed = growthBytes(part) + read_bytes;
    if (held_bytes_ + needed > memory_bytes_) held_bytes_ = density_->memUsage() + color_->memUsage();
    if (held_bytes_ + needed > memory_bytes_) return false;
    held_bytes_ += growthBytes(part);
    return true;
  }
  static std::uint64_t growthBytes(const VoxelBox& part) {
    return static_cast<std::uint64_t>(part.count()) * (sizeof(Baked) + 2);
  }

  openvdb::GridPtrVec finish() {
    density_->pruneGrid(0);
    color_->pruneGrid(0);
    return grids();
  }
  double largestError() const { return 0; }

 private:
  struct Baked {
    float density = 0;
    openvdb::Vec3f color{0};
  };

  static constexpr std::uint64_t kTableBytes = sizeof(T) <= 2 ? sizeof(Baked) << (8 * sizeof(T)) : 0;

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

  std::uint64_t memory_bytes_;
  const TransferFunction& function_;
  const GridPlacement& place_;
  openvdb::FloatGrid::Ptr density_;
  openvdb::Vec3SGrid::Ptr color_;
  std::vector<Baked> table_;  // of types of 8 and 16 bits
  std::uint64_t held_bytes_ = 0;
};

}  // namespace kiln
