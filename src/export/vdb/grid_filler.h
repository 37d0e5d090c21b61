// Voxels of bricks in one grid. A leaf overlaps up to eight bricks unless the grid's coordinates are offset by
// multiples of 8. So voxels are set individually through an accessor; a constant brick is a fill.
// Invariant: unset voxels have the grid's background value, so bricks of background are free.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "export/vdb/brick_voxels.h"
#include "export/vdb/export_vdb.h"
#include "export/vdb/grid_placement.h"

namespace kiln {

/// Fills a grid of type `Grid` with voxels of type T. Every filler has `holds`, `fill`, `take`, `treeBytes`, `finish`,
/// `finishBytes`, `largestError`, and the memory of its parts: `kVoxelBytes`, `kFixedBytes`, `kReach`.
template <class T, class Grid>
class GridFiller {
 public:
  using Value = typename Grid::ValueType;

  /// Upper bound of a voxel in a leaf, and memory beside the tree. unit: bytes.
  static constexpr std::uint64_t kVoxelBytes = sizeof(Value) + 1, kFixedBytes = 0;
  /// Voxels by which a grid reaches beyond the bricks.
  static constexpr int kReach = 0;

  GridFiller(const Manifest& manifest, const VdbValues& values, const GridPlacement& place)
      : values_(values),
        level_set_(manifest.volume_class == VolumeClass::kLevelSet),
        background_(gridBackground(manifest, values)),
        place_(place),
        grid_(newGrid<Grid>(background_)) {
    grid_->setName(place.name);
    grid_->setTransform(transformOf(place.world_from_grid));
    if (manifest.volume_class == VolumeClass::kFog) grid_->setGridClass(openvdb::GRID_FOG_VOLUME);
    if (level_set_) grid_->setGridClass(openvdb::GRID_LEVEL_SET);
  }

  /// Returns whether a box of one value enters the tree.
  bool holds(double constant) { return !isBackground(written(static_cast<T>(constant))); }

  /// Takes a box of one value.
  void fill(const VoxelBox& box, double constant) {
    const Value value = written(static_cast<T>(constant));
    note(value);
    if (isBackground(value)) return;
    grid_->sparseFill({place_.of(box.lo), place_.of({box.hi.x - 1, box.hi.y - 1, box.hi.z - 1})}, value, active(value));
  }

  /// Takes the voxels of `part` of a block.
  void take(const BrickBlock& block, const VoxelBox& part) {
    auto accessor = grid_->getAccessor();
    forEachVoxel<T>(block, part, [&](const VoxelCoord& at, T voxel) {
      const Value value = written(voxel);
      if (isBackground(value)) return;
      note(value);
      if (active(value)) {
        accessor.setValueOn(place_.of(at), value);
      } else {
        accessor.setValueOff(place_.of(at), value);
      }
    });
  }

  /// Memory of the tree as it is. unit: bytes.
  std::uint64_t treeBytes() const { return grid_->memUsage(); }

  /// Memory that `finish` adds. unit: bytes.
  std::uint64_t finishBytes() const { return 0; }
  openvdb::GridPtrVec finish() {
    // Merges nodes of one value and state. OpenVDB compares values by ==: -0 would be lost, and a node whose first
    // value is NaN counts as equal throughout.
    if (!compares_otherwise_) grid_->pruneGrid(0);
    if constexpr (std::is_same_v<Value, float>)
      grid_->setSaveFloatAsHalf(values_.type != VdbType::kFloat && half_ && survivesHalf(background_));
    return {grid_};
  }
  double largestError() const { return largest_error_; }

 private:
  static Value gridBackground(const Manifest& manifest, const VdbValues& values) {
    return rounded(static_cast<Value>(values.background.value_or(manifest.background)), values.type);
  }
  static Value rounded(Value value, VdbType type) {
    if constexpr (std::is_same_v<Value, float>)
      if (type == VdbType::kHalf) return static_cast<float>(openvdb::math::half(value));
    return value;
  }
  // The value that the grid gets for a voxel. An exact grid changes none. The error of a finite voxel that becomes
  // infinite is infinite.
  Value written(T voxel) {
    if (values_.type == VdbType::kExact && values_.tolerance == 0) return static_cast<Value>(voxel);
    const bool near = std::abs(static_cast<double>(voxel) - static_cast<double>(background_)) <= values_.tolerance;
    const Value value = near && values_.tolerance > 0 ? background_ : rounded(static_cast<Value>(voxel), values_.type);
    const double error = std::abs(static_cast<double>(value) - static_cast<double>(voxel));
    if (error > largest_error_) largest_error_ = error;  // false for NaN
    return value;
  }
  bool isBackground(Value value) const { return std::memcmp(&value, &background_, sizeof value) == 0; }
  bool active(Value value) const {
    if constexpr (std::is_floating_point_v<Value>) {
      // The negated >= is also true for NaN: a NaN in a level set stays active, so that users see it.
      if (level_set_) return !(std::abs(value) >= background_);
    }
    return !isBackground(value);
  }
  void note(Value value) {
    if constexpr (std::is_floating_point_v<Value>)
      compares_otherwise_ |= std::isnan(value) || (value == 0 && std::signbit(value));
    if constexpr (std::is_same_v<Value, float>) half_ = half_ && survivesHalf(value);
  }

  const VdbValues& values_;
  bool level_set_;
  Value background_;
  const GridPlacement& place_;
  typename Grid::Ptr grid_;
  double largest_error_ = 0;
  bool half_ = true, compares_otherwise_ = false;  // the latter: a value is -0 or NaN
};

}  // namespace kiln
