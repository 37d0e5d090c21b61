// The voxels of a cell that show something, front to back, and what is read of those that are drawn: materials and
// slopes; the kernels of `--lattice voxel` before and between those that project and lay. This is where the brick's
// memory is touched; a row of a cell is a vector where its values have up to 16 bits. One implementation in Highway,
// the same bits on all instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/shared/classifier.h"
#include "engine/voxel/project_voxels.h"
#include "engine/voxel/rasterize_footprints.h"
#include "grid/visiting_order.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// The voxels along an axis that are splatted at a time: smaller than the cells of the store, because a test is cheaper
/// than eight rows of voxels behind an opaque surface, and not smaller still, because then the tests cost more than
/// they save (figures: engine/voxel/decisions/footprints.md).
inline constexpr int kSplatCellSize = 4;

/// Rows in front-to-back order, and so are their voxels.
struct FoundVoxels {
  struct Row {
    std::ptrdiff_t offset;      // of its first voxel in the brick. unit: voxels
    const std::int32_t* order;  // where in the row those that show something are, then 0; kSplatCellSize
    int begin, count;           // which of `codes` they are
  };
  static constexpr std::size_t kMostRows = std::size_t{kSplatCellSize} * kSplatCellSize;
  static constexpr std::size_t kMost = kMostRows * kSplatCellSize;
  Row rows[kMostRows];  // that have some
  int row_count = 0;
  int count = 0;
  std::int32_t codes[kMost + kVoxelBatch];  // voxelCode from the cell's first voxel on; then anything
};

/// requires: cell not empty, inside block.core, at most kSplatCellSize voxels along an axis.
void findVoxels(const Classifier& classifier, const VisitingOrder& order, const BrickBlock& block, const VoxelBox& cell,
                FoundVoxels& out) noexcept;

/// Of a batch that begins with the found voxel `first`, those that have their bit in `drawn`: materials and, where they
/// are asked for, central differences at voxel scale, of labels those of their opacities. unit: value per voxel.
/// requires: the brick has an apron.
void takeVoxels(const Classifier& classifier, const BrickBlock& block, const FoundVoxels& found, int first,
                std::uint32_t drawn, bool with_slopes, ShadedVoxels& out) noexcept;

}  // namespace kiln
