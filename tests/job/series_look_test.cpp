// The joined volume of a time series. Known because boxes, ranges and counts of all frames are given.
#include "job/frame/series_look.h"

#include <gtest/gtest.h>

#include <numeric>

#include "scene/camera/framing.h"
#include "scene/transfer/label_styles.h"

namespace kiln::test {
namespace {

Manifest frameOf(const Extent3& dims, const glm::dvec3& origin, const ValueRange& range,
                 std::vector<std::uint64_t> counts) {
  Manifest out;
  out.type = VoxelType::f32;
  out.range = range;
  out.histogram = {range.lo, range.hi, std::move(counts)};
  out.levels.resize(1);
  out.levels[0].geometry.dims = dims;
  out.levels[0].geometry.world_from_index[3] = glm::dvec4(origin, 1);
  return out;
}

TEST(SeriesLook, UnionOfFrames_hasAllBoxesValuesAndVoxels) {
  const Manifest all = unionOf({frameOf({10, 10, 10}, {0, 0, 0}, {0, 4}, {10, 20, 30, 40}),
                                frameOf({20, 10, 5}, {-5, 0, 0}, {-4, 8}, {1, 2, 3})});
  EXPECT_EQ(all.range, (ValueRange{-4, 8}));
  EXPECT_EQ(all.geometry().dims, (Extent3{20, 10, 10}));
  EXPECT_EQ(centreOf(all.geometry()), glm::dvec3(4.5));
  EXPECT_EQ(all.histogram.lo, -4);
  EXPECT_EQ(all.histogram.hi, 8);
  const auto& counts = all.histogram.counts;
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), 106u);
  // Four bins, 3 wide: 10 + 20 of the first frame are below 2; a bin of the second frame that overlaps two bins is
  // split.
  EXPECT_EQ(counts, (std::vector<std::uint64_t>{1, 31, 73, 1}));
}

TEST(SeriesLook, OneFrame_standsForItself) {
  const Manifest one = frameOf({10, 10, 10}, {1, 2, 3}, {0, 4}, {10, 20, 30, 40});
  const Manifest all = unionOf({one});
  EXPECT_EQ(all.geometry().world_from_index, one.geometry().world_from_index);
  EXPECT_EQ(all.histogram.counts, one.histogram.counts);
}

TEST(SeriesLook, Labels_keepTheirCounts) {
  const auto labels = [](double lo, std::vector<std::uint64_t> counts) {
    const double n = static_cast<double>(counts.size());
    Manifest out = frameOf({4, 4, 4}, {0, 0, 0}, {lo, lo + n - 1}, std::move(counts));
    out.type = VoxelType::u8;
    out.volume_class = VolumeClass::kLabels;
    out.histogram.lo = lo - 0.5;
    out.histogram.hi = lo + n - 0.5;
    return out;
  };
  const auto found = labelsOf(unionOf({labels(0, {60, 0, 4}), labels(2, {60, 3, 0, 1})}));
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 4u);
  const std::pair<double, std::uint64_t> expected[] = {{0, 60}, {2, 64}, {3, 3}, {5, 1}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ((*found)[i].label, expected[i].first);
    EXPECT_EQ((*found)[i].voxels, expected[i].second);
  }
}

}  // namespace
}  // namespace kiln::test
