#include "engine/pixel/voxels/mask_voxels.h"

#include <algorithm>
#include <array>

namespace kiln {

MaskAround loadMask(const BrickBlock& block, const SampleLattice& lattice, const VoxelCoord& lo, MaskVoxels& out) {
  constexpr int kEdge = WideOpacities::kEdge;
  const int reach = lattice.label_smoothing, wide = kEdge + 2 * reach;
  const VoxelBox& has = block.extent;
  const std::int64_t margin = kPatchMargin + reach;
  const VoxelBox read = {{lo.x - margin, lo.y - margin, lo.z - margin},
                         {lo.x - margin + wide, lo.y - margin + wide, lo.z - margin + wide}};
  const VoxelBox known = intersection(read, has);
  if (block.shown.every(known)) return MaskAround::kAll;
  const VoxelBox samples = intersection(dilated(read, -(margin - 1)), has);
  if (!block.shown.any(samples)) return MaskAround::kNone;
  std::array<std::int64_t, WideOpacities::kWide> at[3];
  for (int a = 0; a < 3; ++a) voxelOffsets(block, a, read.lo[a], wide, at[a].data());
  for (std::size_t k = 0; k < static_cast<std::size_t>(wide); ++k) {
    for (std::size_t j = 0; j < static_cast<std::size_t>(wide); ++j) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(wide); ++i)
        out.wide.at(i, j, k) = block.shown.at(at[0][i] + at[1][j] + at[2][k]) ? 1.0f : 0.0f;
    }
  }
  const auto first = static_cast<std::size_t>(reach), edge = static_cast<std::size_t>(kEdge);
  for (std::size_t k = 0; k < edge; ++k) {
    for (std::size_t j = 0; j < edge; ++j)
      std::copy_n(&out.wide.at(first, j + first, k + first), kEdge, out.shown + (k * edge + j) * kPatchStride);
  }
  out.wide.smooth(reach, out.smoothed);
  return MaskAround::kSome;
}

}  // namespace kiln
