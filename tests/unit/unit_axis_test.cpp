// Where samples lie along an axis: evenly, whatever units they are in, and each in one unit; of a volume that ends
// among them, parts that add up to it.
#include "splat/unit_axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kiln::test {
namespace {

// Whole ones, some between, and the most.
constexpr int kSamples[] = {8, 9, 13, 16, 23, 24, 31, 57, 120, 128};

std::vector<int> unitsOf(const Refinement& refinement) {
  std::vector<int> out;
  for (int voxels = 1; voxels <= kUnitVoxels; voxels *= 2) {
    if (unitHasRoom(refinement, voxels)) out.push_back(voxels);
  }
  return out;
}

TEST(UnitAxis, HasEachSampleOnceAndAllEvenly) {
  for (const int samples : kSamples) {
    const Refinement refinement{samples};
    ASSERT_FALSE(unitsOf(refinement).empty()) << samples;
    for (const int voxels : unitsOf(refinement)) {
      SCOPED_TRACE(testing::Message() << samples << " samples of 8 voxels, units of " << voxels);
      int next = 0;
      for (int first = 0; first < kRefinedVoxels; first += voxels) {
        const UnitAxis axis(refinement, first, voxels, Interpolation::kLinear);
        ASSERT_LE(axis.samples, kUnitSamples);
        for (int i = 0; i < axis.samples; ++i, ++next) {
          const auto at = static_cast<std::size_t>(i);
          const double place = (next + 0.5) * kRefinedVoxels / samples - 0.5 - first;
          EXPECT_NEAR(axis.offset[at], place, 1e-6);
          EXPECT_NEAR(axis.base[at] - kUnitMargin + static_cast<double>(axis.fraction[at]), place, 1e-6);
        }
        for (int v = 0; v <= voxels; ++v) {
          const int before = axis.before[static_cast<std::size_t>(v)];
          EXPECT_TRUE(before == 0 || static_cast<double>(axis.offset[static_cast<std::size_t>(before) - 1]) < v - 0.5);
          EXPECT_TRUE(before == axis.samples ||
                      axis.offset[static_cast<std::size_t>(before)] >= static_cast<float>(v) - 0.5f);
        }
      }
      EXPECT_EQ(next, samples);
    }
  }
}

TEST(UnitAxis, PartsOfItsSamplesAddUpToWhatThereIs) {
  for (const int samples : kSamples) {
    const Refinement refinement{samples};
    for (const int voxels : unitsOf(refinement)) {
      for (int first = 0; first < kRefinedVoxels; first += voxels) {
        const UnitAxis axis(refinement, first, voxels, Interpolation::kLinear);
        for (double end = 0.5; end <= voxels; end += 0.5) {
          double sum = 0;
          for (const float part : axis.partsBefore(end)) sum += static_cast<double>(part) * axis.step;
          // What of the unit's first sample is before it is the last unit's.
          const double before_first = static_cast<double>(axis.offset[0]) + 0.5 - 0.5 * axis.step;
          EXPECT_NEAR(sum, end - before_first, 1e-3) << samples << ", " << voxels << ", " << first << ", " << end;
        }
      }
    }
  }
}

TEST(Refinement, KnowsHowNearSamplesAreToFaces) {
  EXPECT_DOUBLE_EQ(Refinement{8}.leastFromFace(), 0.5);
  EXPECT_DOUBLE_EQ(Refinement{24}.leastFromFace(), 0.5 / 3);
  EXPECT_DOUBLE_EQ(Refinement{13}.leastFromFace(), 0);  // one is in the face between the fourth voxel and the fifth
}

}  // namespace
}  // namespace kiln::test
