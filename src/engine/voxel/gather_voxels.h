// Finds the visible voxels of a cell in front-to-back order, and gathers materials and gradients of the voxels that are
// drawn.
// Method. These kernels run before projection and between projection and rasterization; only they read the brick's
// memory. A cell row is one vector if values have up to 16 bits.
// Invariant. One Highway implementation returns equal bits on all instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/shared/classifier.h"
#include "engine/voxel/project_voxels.h"
#include "engine/voxel/rasterize_footprints.h"
#include "grid/visiting_order.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// Edge of the cell that is splatted at a time. Smaller than the store's cells: a visibility test is cheaper than
/// reading eight rows of voxels behind an opaque surface. Below 4 the tests cost more than they save (figures:
/// occlusion/decisions/tested-boxes.md). unit: voxels.
inline constexpr int kSplatCellSize = 4;

/// Visible voxels of a cell. Rows and the voxels of a row are in front-to-back order.
struct FoundVoxels {
  struct Row {
    std::ptrdiff_t offset;      // first voxel of the row in the brick. unit: voxels
    const std::int32_t* order;  // positions of visible voxels in the row, then zeros. shape: kSplatCellSize
    int begin, count;           // range of the row in `codes`
  };
  static constexpr std::size_t kMostRows = std::size_t{kSplatCellSize} * kSplatCellSize;
  static constexpr std::size_t kMost = kMostRows * kSplatCellSize;
  Row rows[kMostRows];  // rows with at least one visible voxel
  int row_count = 0;
  int count = 0;
  std::int32_t codes[kMost + kVoxelBatch];  // voxelCode relative to the cell's first voxel; undefined from `count` on
};

/// Finds the visible voxels of `cell`. requires: cell not empty, inside block.core, at most kSplatCellSize voxels along
/// an axis.
void findVoxels(const Classifier& classifier, const VisitingOrder& order, const BrickBlock& block, const VoxelBox& cell,
                FoundVoxels& out) noexcept;

/// Gathers the material of each voxel whose bit is set in `drawn`; bit 0 is the found voxel `first`. With `with_slopes`
/// also gathers central differences at voxel scale: differences of values, or of opacities if values are labels. unit:
/// value per voxel. requires: the brick has an apron.
void takeVoxels(const Classifier& classifier, const BrickBlock& block, const FoundVoxels& found, int first,
                std::uint32_t drawn, bool with_slopes, ShadedVoxels& out) noexcept;

}  // namespace kiln
