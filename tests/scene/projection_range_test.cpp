// Known answers: means along rays through nested cubes, of which the histogram is exact; maxima that a histogram's tail
// cannot cover more pixels with than it has voxels.
#include "scene/transfer/projection_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "scene/transfer/preset_ranges.h"

namespace kiln {
namespace {

struct Voxels {
  double value;
  std::uint64_t count;
};

// A volume of 100³ voxels with values from `lo` to `hi`.
Manifest volumeOfValues(double lo, double hi, const std::vector<Voxels>& voxels) {
  Manifest manifest;
  manifest.type = VoxelType::f32;
  manifest.range = {lo, hi};
  manifest.histogram = {lo, hi, std::vector<std::uint64_t>(256)};
  for (const auto& [value, count] : voxels) {
    const double bin = std::clamp((value - lo) / (hi - lo) * 256, 0.0, 255.0);
    manifest.histogram.counts[static_cast<std::size_t>(bin)] += count;
  }
  manifest.levels.resize(1);
  manifest.levels[0].geometry.dims = {100, 100, 100};
  return manifest;
}

constexpr double kBin = 200.0 / 256;
constexpr std::uint64_t kInner = 20 * 20 * 20, kOuter = 50 * 50 * 50 - kInner;
// A cube of 20³ voxels of value 200 inside a cube of 50³ voxels of value 100, in empty space.
Manifest nestedCubes() {
  return volumeOfValues(0, 200, {{0, 1000000 - kOuter - kInner}, {100, kOuter}, {200, kInner}});
}

// The ray through the middle: 50 voxels of 0, 30 of 100, 20 of 200.
TEST(ProjectionRange, Average_endsAtTheMeanThroughTheMiddle) {
  const ValueRange range = projectionRange(nestedCubes(), Mode::kAverage);
  EXPECT_NEAR(range.lo, 0, kBin);
  EXPECT_NEAR(range.hi, (30 * 100 + 20 * 200) / 100.0, kBin);
}

// Clipped to the outer cube, the ray has 50 voxels.
TEST(ProjectionRange, Average_knowsTheShownPart) {
  const ValueRange range = projectionRange(nestedCubes(), Mode::kAverage, 0.125);
  EXPECT_NEAR(range.hi, (30 * 100 + 20 * 200) / 50.0, kBin);
}

// 200 voxels of 100000 cover at most 2 % of a face, and less than 1 % if they are three voxels deep.
TEST(ProjectionRange, Maximum_endsWhereFewPixelsAreBrighter) {
  const auto with = [](std::uint64_t outliers) {
    return volumeOfValues(0, 2560, {{0, 700000}, {300, 280000}, {1005, 20000 - outliers}, {2560, outliers}});
  };
  const ValueRange usual = projectionRange(with(200), Mode::kMip);
  EXPECT_NEAR(usual.hi, 1010, 10);
  EXPECT_EQ(projectionRange(with(200), Mode::kAttenuatedMip).hi, usual.hi);
  EXPECT_GT(projectionRange(with(400), Mode::kMip).hi, 2500);
}

// Noise of 20 around 100: its maxima along rays are about 100 + 2.5 · 20. The object is not cut off.
TEST(ProjectionRange, Maximum_beginsAboveTheNoiseOfEmptySpace) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(100, 20);
  std::vector<Voxels> voxels = {{500, 100000}, {1000, 20000}};
  for (int i = 0; i < 88000; ++i) voxels.push_back({noise(random), 10});
  const ValueRange range = projectionRange(volumeOfValues(0, 1000, voxels), Mode::kMip);
  EXPECT_NEAR(range.lo, 140, 6);
  EXPECT_GT(range.hi, 990);
}

TEST(ProjectionRange, Minimum_endsInTheMiddleOfTheObject) {
  const ValueRange range = projectionRange(
      volumeOfValues(-1000, 1000, {{-1000, 500000}, {0, 100000}, {50, 300000}, {1000, 100000}}), Mode::kMinip);
  EXPECT_NEAR(range.lo, -1000, 8);
  EXPECT_NEAR(range.hi, 50, 8);
}

TEST(ProjectionRange, VolumesWithoutAnObject_showAllValues) {
  Manifest level_set = nestedCubes();
  level_set.volume_class = VolumeClass::kLevelSet;
  for (const Manifest& volume : {level_set, volumeOfValues(0, 200, {{30, 1000000}}), volumeOfValues(0, 200, {})}) {
    for (const Mode mode : {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip})
      EXPECT_EQ(projectionRange(volume, mode), usableRange(volume));
  }
}

TEST(ProjectionRange, StaysInTheValues_whateverTheHistogram) {
  std::mt19937 random(7);
  for (int n = 0; n < 300; ++n) {
    std::vector<Voxels> voxels;
    for (int i = 0; i <= n % 40; ++i)
      voxels.push_back({std::uniform_real_distribution<double>(-50, 900)(random),
                        std::uint64_t{1} << std::uniform_int_distribution<int>(0, 40)(random)});
    const Manifest volume = volumeOfValues(-50, 900, voxels);
    for (const Mode mode : {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip}) {
      const ValueRange range = projectionRange(volume, mode, 0.3);
      EXPECT_LT(range.lo, range.hi) << n;
      EXPECT_GE(range.lo, -50) << n;
      EXPECT_LE(range.hi, 900) << n;
    }
  }
}

}  // namespace
}  // namespace kiln
