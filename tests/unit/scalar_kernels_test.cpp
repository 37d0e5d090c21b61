// Kernels on every instruction set against the same written plainly (support/scalar_kernels.h), bit for bit: operations
// are neither fused nor approximate, and sums are whole numbers.
#include "support/scalar_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "splat/refine_unit.h"
#include "support/procedural.h"

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
    // In some of the units that are loaded.
    if constexpr (std::is_floating_point_v<T>)
      voxels[block.offsetOf({5, 6, 7})] = voxels[block.offsetOf({17, 18, 19})] = NAN;
  });
  return block;
}

TEST(ScalarKernels, UnitsAreLoadedAlike) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::i8, VoxelType::u16, VoxelType::i16, VoxelType::f32}) {
    const BrickBlock block = noiseBlock(type);
    // A range is found among floats, from which the offset has been taken.
    const double rounding = type == VoxelType::f32 ? 120 * 6e-8 : 0;
    for (const int voxels : {4, 5, 8}) {
      for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
        UnitLattice lattice;
        lattice.interpolation = interpolation;
        lattice.voxels = {voxels, 4, 3};
        lattice.blocks = voxels == 8 ? 2 : 1;
        // In the middle, and where its margin is beyond what the brick has.
        for (const VoxelCoord& lo : {VoxelCoord{4, 5, 6}, VoxelCoord{-6, -6, -6}, VoxelCoord{16, 17, 18}}) {
          constexpr std::size_t kCount =
              std::size_t{kUnitVoxels + 2 * kUnitMargin} * (kUnitVoxels + 2 * kUnitMargin) * kUnitSamples;
          alignas(64) float truth[kCount], found[kCount];
          const UnitRanges ranges = loadUnitScalar(block, lattice, 7, lo, truth);
          onEveryInstructionSet([&](std::int64_t target) {
            std::fill_n(found, kCount, -1.0f);
            const UnitRanges others = loadUnit(block, lattice, 7, lo, found);
            const auto expectAlike = [&](const SampledRange& other, const SampledRange& range) {
              EXPECT_EQ(other.gaps, range.gaps) << target;
              ASSERT_EQ(other.values.empty(), range.values.empty()) << target;
              if (range.values.empty()) return;
              EXPECT_NEAR(other.values.lo, range.values.lo, rounding) << target;
              EXPECT_NEAR(other.values.hi, range.values.hi, rounding) << target;
            };
            expectAlike(others.whole, ranges.whole);
            for (std::size_t half = 0; half < 2; ++half) expectAlike(others.blocks[half], ranges.blocks[half]);
            for (int row = 0; row < (4 + 2 * kUnitMargin) * (3 + 2 * kUnitMargin); ++row) {
              EXPECT_TRUE(std::equal(truth + row * kUnitSamples, truth + row * kUnitSamples + voxels + 2 * kUnitMargin,
                                     found + row * kUnitSamples,
                                     [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }))
                  << "instruction set " << target << ", row " << row;
            }
          });
        }
      }
    }
  }
}

TEST(ScalarKernels, SamplesAreAddedAlike) {
  const PixelRect rect = {8, 16, 40, 48};
  // Those of large samples are clipped to the tile; of very large ones they have fewer phases.
  for (const double sigma : {0.27, 0.42, 0.6, 0.9, 2.5, 20.0, 100.0, 300.0}) {
    const FootprintTable footprint(sigma);
    const float color_unit = sigma == 0.6 || sigma == 20 ? 8 : 1;
    std::vector<SlabSample> samples(300);
    std::vector<const SlabSample*> pointers;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto unit = [&, n = std::uint64_t{0}]() mutable {
        return static_cast<float>(hashUnit(17 * i + n++, static_cast<std::uint64_t>(i)));
      };
      auto next = unit;
      SlabSample& s = samples[i];
      s.r = next(), s.g = next(), s.b = next(), s.opacity = next();
      s.front = next() < 0.2f ? 0 : 0.3f * next(), s.back = next() < 0.3f ? 0 : 0.3f * next();
      const auto upTo = [&](int n) { return std::min(static_cast<int>(static_cast<float>(n) * next()), n - 1); };
      const int windows = rect.width() + footprint.taps() - 1;
      s.place.window = upTo(windows) | upTo(windows) << 16;
      s.place.phases = upTo(FootprintPlace::kPhases) | upTo(FootprintPlace::kPhases) << 8;
      pointers.push_back(&s);
    }
    Sheet truth[2];
    for (Sheet& sheet : truth) sheet.reset(rect, footprint, color_unit);
    addSamplesScalar(pointers, footprint, truth[0], truth[1]);
    onEveryInstructionSet([&](std::int64_t target) {
      Sheet found[2];
      for (Sheet& sheet : found) sheet.reset(rect, footprint, color_unit);
      addSamples(pointers, footprint, found[0], found[1]);
      for (int k = 0; k < 2; ++k) {
        for (int y = rect.y0; y < rect.y1; ++y) {
          EXPECT_TRUE(
              std::equal(truth[k].at(rect.x0, y), truth[k].at(rect.x0, y) + 4 * rect.width(), found[k].at(rect.x0, y)))
              << "instruction set " << target << ", sheet " << k << ", row " << y;
          EXPECT_TRUE(std::equal(truth[k].filledAt(rect.x0, y), truth[k].filledAt(rect.x0, y) + rect.width(),
                                 found[k].filledAt(rect.x0, y)))
              << "instruction set " << target << ", sheet " << k << ", row " << y;
        }
      }
    });
  }
}

}  // namespace
}  // namespace kiln::test
