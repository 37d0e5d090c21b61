// Which voxels of a box a mask shows: a bit per voxel, x fastest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grid/coords.h"

namespace kiln {

class ShownVoxels {
 public:
  /// All voxels are shown, and there is no memory.
  ShownVoxels() = default;
  /// No voxel of the box is shown yet.
  explicit ShownVoxels(const VoxelBox& box) : box_(box), words_(wordsOf(box)) {}

  bool all() const { return words_.empty(); }
  /// `offset` counts the voxels of the box before a voxel. requires: !all().
  bool at(std::int64_t offset) const {
    return (words_[static_cast<std::size_t>(offset >> 6)] >> (offset & 63) & 1) != 0;
  }
  /// Voxels of the box before a voxel of the box.
  std::int64_t offsetOf(const VoxelCoord& v) const {
    const Extent3 size = box_.extent();
    return ((v.z - box_.lo.z) * size.y + (v.y - box_.lo.y)) * size.x + v.x - box_.lo.x;
  }
  /// Returns whether a voxel of the box is shown.
  bool shows(const VoxelCoord& v) const { return all() || at(offsetOf(v)); }
  /// Shows `count` voxels from `offset` on. requires: !all().
  void show(std::int64_t offset, std::int64_t count = 1);
  /// Returns whether some voxel, or every voxel, of `part` is shown. requires: `part` lies in the box.
  bool any(const VoxelBox& part) const;
  bool every(const VoxelBox& part) const;
  std::size_t bytes() const { return words_.size() * sizeof(std::uint64_t); }
  /// Memory for a box. unit: bytes.
  static std::size_t bytesFor(const VoxelBox& box) { return wordsOf(box) * sizeof(std::uint64_t); }

 private:
  static std::size_t wordsOf(const VoxelBox& box) { return static_cast<std::size_t>((box.count() + 63) / 64); }
  template <class Test>
  bool anyWord(const VoxelBox& part, const Test& test) const;

  VoxelBox box_;
  std::vector<std::uint64_t> words_;
};

}  // namespace kiln
