#include "engine/pixel/voxels/color_patch.h"

#include <array>
#include <cmath>
#include <limits>

namespace kiln {

void loadColors(const BrickBlock& block, const SampleTable& table, const VoxelCoord& lo, ColorPatch& out) {
  std::array<std::int64_t, kPatchEdge> at[3];
  for (int a = 0; a < 3; ++a) voxelOffsets(block, a, lo[a] - kPatchMargin, kPatchEdge, at[a].data());
  const auto placeOf = [&](float value) {
    const auto above = static_cast<float>(static_cast<double>(value) - table.offset());
    if (!table.ofLabels() || std::isnan(value)) return above * table.scale();
    const int rank = table.rankOf(above);
    return rank < 0 ? std::numeric_limits<float>::quiet_NaN() : SampleTable::placeOf(rank, 1);
  };
  float* to = out.places;
  for (const std::int64_t z : at[2]) {
    for (const std::int64_t y : at[1]) {
      for (std::size_t x = 0; x < kPatchEdge; ++x)
        to[x] = placeOf(block.color_values[static_cast<std::size_t>(at[0][x] + y + z)]);
      to += kPatchStride;
    }
  }
}

}  // namespace kiln
