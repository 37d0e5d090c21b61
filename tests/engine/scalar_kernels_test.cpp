// Kernels on every instruction set against plain loops (support/reference/scalar_kernels.h), bit for bit: operations
// are neither fused nor approximate, and sums are integers.
#include "support/reference/scalar_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

BrickBlock noiseBlock(VoxelType type) {
  BrickBlock block;
  block.type = type;
  block.core = {{0, 0, 0}, {16, 16, 16}};
  block.extent = dilated(block.core, 6);
  block.voxels.resize(static_cast<std::size_t>(block.extent.count()) * sizeOf(type));
  withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    T* const voxels = reinterpret_cast<T*>(block.voxels.data());
    for (std::int64_t i = 0; i < block.extent.count(); ++i)
      voxels[i] = static_cast<T>(120 * hashUnit(5, static_cast<std::uint64_t>(i)));
    // Some of the loaded patches contain NaN.
    if constexpr (std::is_floating_point_v<T>)
      voxels[block.offsetOf({5, 6, 7})] = voxels[block.offsetOf({17, 18, 19})] = NAN;
  });
  return block;
}

TEST(ScalarKernels, PatchesAreLoadedAlike) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::i8, VoxelType::u16, VoxelType::i16, VoxelType::f32}) {
    const BrickBlock block = noiseBlock(type);
    // Ranges of floats are computed after subtraction of the offset.
    const double rounding = type == VoxelType::f32 ? 120 * 6e-8 : 0;
    for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
      SampleLattice lattice;
      lattice.interpolation = interpolation;
      // Positions in the middle, and at both ends, where the margin reaches beyond the brick.
      for (const VoxelCoord& lo : {VoxelCoord{4, 5, 6}, VoxelCoord{-6, -6, -6}, VoxelCoord{16, 17, 18}}) {
        constexpr int kEdge = kPatchVoxels + 2 * kPatchMargin;
        constexpr std::size_t kCount = std::size_t{kEdge} * kEdge * kPatchStride;
        alignas(64) float truth[kCount], found[kCount + kPatchStride];
        const SampledRange range = loadPatchScalar(block, lattice, 7, lo, truth);
        onEveryInstructionSet([&](std::int64_t target) {
          std::fill(std::begin(found), std::end(found), -1.0f);
          const SampledRange other = loadPatch(block, lattice, 7, lo, found);
          EXPECT_EQ(other.gaps, range.gaps) << target;
          ASSERT_EQ(other.values.empty(), range.values.empty()) << target;
          EXPECT_NEAR(other.values.lo, range.values.lo, rounding) << target;
          EXPECT_NEAR(other.values.hi, range.values.hi, rounding) << target;
          for (int row = 0; row < kEdge * kEdge; ++row) {
            EXPECT_TRUE(std::equal(truth + row * kPatchStride, truth + row * kPatchStride + kEdge,
                                   found + row * kPatchStride,
                                   [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }))
                << "instruction set " << target << ", row " << row;
          }
        });
      }
    }
  }
}

}  // namespace
}  // namespace kiln::test
