// Counting is exact for 8 and 16 bits. For wider types every voxel is counted once, in a bin within 1/128 of its value
// or nearer. Known from a plain count.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "convert/stream/value_counter.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

ValueHistogram count(const DenseVolume& volume, std::uint64_t* nan_count = nullptr) {
  ValueCounter counter(volume.type);
  const VoxelBox box = boxOf(volume.geometry.dims);
  counter.count(volume.voxels, box, box);
  if (nan_count != nullptr) *nan_count = counter.nanCount();
  return counter.histogram(volume.range());
}

TEST(ValueCounter, IsExactForSmallIntegers) {
  const DenseVolume volume = noise({{20, 20, 20}, VoxelType::u8}, 3, {0, 255});
  const ValueHistogram histogram = count(volume);
  ASSERT_EQ(histogram.counts.size(), 256u);
  std::vector<std::uint64_t> plain(256);
  const ValueRange range = volume.range();
  for (const std::byte voxel : volume.voxels) {
    const double bin = (static_cast<double>(voxel) - range.lo) / ((range.hi - range.lo) / 256);
    ++plain[static_cast<std::size_t>(std::min(bin, 255.0))];
  }
  EXPECT_EQ(histogram.counts, plain);
}

TEST(ValueCounter, CountsEveryVoxelOfEveryTypeOnce) {
  for (int type = 0; type < 8; ++type) {
    const auto voxel_type = static_cast<VoxelType>(type);
    const DenseVolume volume = noise({{17, 9, 11}, voxel_type}, 4, usualRange(voxel_type));
    const ValueHistogram histogram = count(volume);
    EXPECT_EQ(std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::uint64_t{0}), 17u * 9 * 11)
        << nameOf(voxel_type);
    EXPECT_EQ(histogram.lo, volume.range().lo);
    EXPECT_EQ(histogram.hi, volume.range().hi);
  }
}

// Known because each voxel's label is a thousand times its x: 12 voxels each.
TEST(ValueCounter, CountsEachLabelOfAWideType) {
  const DenseVolume volume = fill({{9, 3, 4}, VoxelType::i32}, [](auto x, auto, auto) { return 1000.0 * x; });
  ValueCounter counter(volume.type, true);
  counter.count(volume.voxels, boxOf(volume.geometry.dims), boxOf(volume.geometry.dims));
  const ValueHistogram histogram = counter.histogram({-0.5, 8000.5}, 8001);
  for (std::size_t label = 0; label < 8001; ++label)
    EXPECT_EQ(histogram.counts[label], label % 1000 == 0 ? 12u : 0u) << label;
}

TEST(ValueCounter, FindsTheMiddleOfUniformFloats) {
  const DenseVolume volume = noise({{40, 40, 40}, VoxelType::f32}, 5, {-10, 30});
  const ValueHistogram histogram = count(volume);
  const auto middle = histogram.counts.begin() + 128;
  const double below = static_cast<double>(std::accumulate(histogram.counts.begin(), middle, std::uint64_t{0}));
  EXPECT_NEAR(below / 64000, 0.5, 0.02);
}

// Known because an offset only shifts a histogram: a ball 20 above its surroundings, a spot of 2000, noise of 1, and
// all of it at a pressure of 101325.
TEST(ValueCounter, FloatsWithAnOffset_haveTheHistogramOfFloatsWithout) {
  const auto histogramAt = [](double offset) {
    const DenseVolume volume = fill({{40, 40, 40}, VoxelType::f32}, [&](auto x, auto y, auto z) {
      const double i = x - 20, j = y - 20, k = z - 20;
      const auto place = static_cast<std::uint64_t>(x + 40 * (y + 40 * z));
      const double noise = hashUnit(1, place) + hashUnit(2, place) + hashUnit(3, place) - 1.5;
      const bool spot = (i - 8) * (i - 8) + j * j + k * k < 9;
      return offset + (spot ? 2000 : (i * i + j * j + k * k < 144 ? 20 : 0) + noise);
    });
    ValueCounter counter(volume.type);
    counter.count(volume.voxels, boxOf(volume.geometry.dims), boxOf(volume.geometry.dims));
    return counter.histogram({offset - 1.5, offset + 2000});
  };
  const ValueHistogram plain = histogramAt(0), moved = histogramAt(101325);
  double difference = 0;
  for (std::size_t bin = 0; bin < kHistogramBins; ++bin)
    difference += std::abs(static_cast<double>(plain.counts[bin]) - static_cast<double>(moved.counts[bin]));
  EXPECT_LT(difference, 0.02 * 64000);
}

// The order of counting and the distribution of boxes to counters must not change a store.
TEST(ValueCounter, FloatsCountedInParts_areTheSameHistogram) {
  const DenseVolume volume = fill({{32, 8, 8}, VoxelType::f32}, [](auto x, auto y, auto z) {
    const auto place = static_cast<std::uint64_t>(x + 32 * (y + 8 * z));
    return x < 16 ? 101325 + hashUnit(1, place) : 1e6 * (hashUnit(2, place) - 0.5);
  });
  const VoxelBox all = boxOf(volume.geometry.dims);
  ValueCounter whole(volume.type), parts(volume.type), part(volume.type), backwards(volume.type);
  whole.count(volume.voxels, all, all);
  for (const std::int64_t x : {0, 8, 16, 24}) {
    part.count(volume.voxels, all, {{x, 0, 0}, {x + 8, 8, 8}});
    parts.add(part.take());
    backwards.count(volume.voxels, all, {{24 - x, 0, 0}, {32 - x, 8, 8}});
  }
  const ValueRange range = volume.range();
  EXPECT_EQ(whole.histogram(range).counts, parts.histogram(range).counts);
  EXPECT_EQ(whole.histogram(range).counts, backwards.histogram(range).counts);
  EXPECT_EQ(whole.take().keys.size(), parts.take().keys.size());
}

// Known because the noise ranges from -10 to 30, and the test adds the stray values in known numbers.
TEST(ValueCounter, FindsWhatIsNotStray) {
  const DenseVolume clean = noise({{40, 40, 40}, VoxelType::f32}, 5, {-10, 30});
  const auto commonOf = [&](float stray, std::int64_t voxels) {
    DenseVolume volume = clean;
    for (std::int64_t i = 0; i < voxels; ++i) volume.set(i % 40, i / 40 % 40, i / 1600, stray);
    ValueCounter counter(volume.type);
    counter.count(volume.voxels, boxOf(volume.geometry.dims), boxOf(volume.geometry.dims));
    const ValueRange of_clean = clean.range();
    const ValueRange all{std::min<double>(of_clean.lo, stray), std::max<double>(of_clean.hi, stray)};
    const ValueRange common = counter.commonRange(all);
    const ValueHistogram histogram = counter.histogram(common);
    EXPECT_EQ(std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::uint64_t{0}), 64000u);
    return common.lo == all.lo && common.hi == all.hi ? ValueRange{} : common;
  };
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float stray : {1e4f, -9999.f, 1e30f, -3.4e38f, kInfinity, -kInfinity}) {
    const ValueRange common = commonOf(stray, 1);
    EXPECT_NEAR(common.lo, -10, 0.1) << stray;
    EXPECT_NEAR(common.hi, 30, 0.2) << stray;
  }
  // A value of half of the voxels is no stray value, unless it is extremely far away.
  EXPECT_TRUE(commonOf(1e4f, 32000).empty());
  EXPECT_NEAR(commonOf(1e30f, 32000).hi, 30, 0.2);
  EXPECT_NEAR(commonOf(-9.97e36f, 32000).lo, -10, 0.1);
  // A value that only widens the range a few times is no stray value either.
  EXPECT_TRUE(commonOf(300, 1).empty());
  EXPECT_TRUE(commonOf(7, 1).empty());
}

TEST(ValueCounter, KeepsTheRangeOfFewValues) {
  const DenseVolume volume = fill({{9, 30, 40}, VoxelType::i32}, [](auto x, auto, auto) { return x == 8 ? 1e9 : x; });
  for (const bool labels : {false, true}) {
    ValueCounter counter(volume.type, labels);
    counter.count(volume.voxels, boxOf(volume.geometry.dims), boxOf(volume.geometry.dims));
    EXPECT_EQ(counter.commonRange(volume.range()).hi, 1e9);
  }
}

TEST(ValueCounter, LeavesNanAside) {
  DenseVolume volume = noise({{4, 4, 4}, VoxelType::f32}, 6, {1, 2});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(volume.voxels.data(), &nan, sizeof nan);
  std::uint64_t nan_count = 0;
  const ValueHistogram histogram = count(volume, &nan_count);
  EXPECT_EQ(nan_count, 1u);
  EXPECT_EQ(std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::uint64_t{0}), 63u);
}

}  // namespace
}  // namespace kiln::test
