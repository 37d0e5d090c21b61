// Ranges that a table reports as soft or as interesting. Known because the functions consist of a few straight lines
// with a readable total change.
#include "engine/pixel/voxels/sample_table.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kiln {
namespace {

constexpr ValueRange kAll{0, 255};

// Returns the opacity that gives a voxel of length 1 this optical depth.
double ofDepth(double depth) { return -std::expm1(-depth); }

SampleTable tableOf(std::vector<TransferPoint> points, VoxelType type = VoxelType::u8, const ValueRange& range = kAll) {
  return SampleTable({1, std::move(points)}, 1, type, range);
}

// Depth 3 up to 100, none from 110 on.
std::vector<TransferPoint> cliff() { return {{100, {1, 1, 1}, ofDepth(3)}, {110, {1, 1, 1}, 0}}; }

TEST(SampleTable, IsSoftWhereNothingChangesByMoreThanOne) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::f32}) {
    const SampleTable table = tableOf(cliff(), type);
    EXPECT_TRUE(table.soft({0, 100}, 1));
    EXPECT_TRUE(table.soft({110, 255}, 1));
    EXPECT_FALSE(table.soft({99, 111}, 1));
    EXPECT_FALSE(table.soft({0, 255}, 1));
    // Half of the opacity is less than 1, three quarters are more.
    EXPECT_TRUE(table.soft({105, 200}, 1));
    EXPECT_FALSE(table.soft({102, 200}, 1));
    // A shorter voxel has a smaller change, a longer voxel a larger one.
    EXPECT_TRUE(table.soft({99, 111}, 0.3));
    EXPECT_FALSE(table.soft({105, 200}, 2));
    // Values beyond the range are clamped to its ends.
    EXPECT_TRUE(table.soft({-50, 90}, 1));
    EXPECT_TRUE(table.soft({120, 900}, 1));
  }
}

// Known because the function rises from nothing at 50 to a depth of 0.4 at 150, linearly in opacity.
TEST(SampleTable, IsEvenWhereNoLayerEnds) {
  const SampleTable table = tableOf({{50, {1, 1, 1}, 0}, {150, {1, 1, 1}, ofDepth(0.4)}});
  EXPECT_TRUE(table.even({0, 50}, 1));
  EXPECT_FALSE(table.even({0, 150}, 1));
  EXPECT_TRUE(table.even({100, 150}, 1));
  EXPECT_TRUE(table.even({0, 60}, 1)) << "faint";
  EXPECT_FALSE(table.even({0, 60}, 4));
  EXPECT_TRUE(table.even({0, 150}, 0.1));
}

// Known because the colour is constant up to 100 and from 150 on.
TEST(SampleTable, HasOneColorWhereNoValueHasAnother) {
  const glm::dvec3 red(0.9, 0.3, 0.1), blue(0.1, 0.2, 0.7);
  for (const VoxelType type : {VoxelType::u8, VoxelType::f32}) {
    const SampleTable table = tableOf({{50, red, 0}, {100, red, 0.9}, {150, blue, 0.9}}, type);
    for (const ValueRange& range : {ValueRange{0, 99}, {60, 61}, {151, 255}, {-50, 20}, {200, 900}}) {
      SCOPED_TRACE(testing::Message() << range.lo << " to " << range.hi);
      const float* const color = table.oneColor(range);
      ASSERT_NE(color, nullptr);
      for (double value = range.lo; value <= range.hi; value += 0.25) {
        const Material at = table.at(static_cast<float>(value));
        EXPECT_TRUE(at.r == color[0] && at.g == color[1] && at.b == color[2]) << value;
      }
    }
    for (const ValueRange& range : {ValueRange{0, 101}, {99, 151}, {110, 120}, {149, 200}, {0, 255}})
      EXPECT_EQ(table.oneColor(range), nullptr) << range.lo << " to " << range.hi;
  }
}

// Known because a function is constant beyond its points, for every range of values.
TEST(SampleTable, TellsApartWhatItsFunctionDoes) {
  const std::vector<TransferPoint> ramp = {{9, {1, 1, 1}, 0}, {11, {1, 1, 1}, ofDepth(1)}};
  for (const ValueRange& range : {ValueRange{0, 30}, {0, 1e30}, {-3.4e38, 30}, {-INFINITY, INFINITY}}) {
    SCOPED_TRACE(testing::Message() << range.lo << " to " << range.hi);
    const SampleTable table = tableOf(ramp, VoxelType::f32, range);
    const auto tauOf = [&](double value) { return table.at(static_cast<float>(value - table.offset())).tau; };
    EXPECT_NEAR(tauOf(10), extinctionOf(ofDepth(1) / 2, 1), 0.01);
    EXPECT_NEAR(tauOf(9.5), extinctionOf(ofDepth(1) / 4, 1), 0.01);
    for (const double value : {-3.4e38, -1e5, 0.0, 8.9}) EXPECT_EQ(tauOf(value), 0) << value;
    for (const double value : {11.1, 30.0, 1e5, 1e30}) EXPECT_NEAR(tauOf(value), 1, 1e-6) << value;
    EXPECT_FALSE(table.interesting({range.lo, 8.9}));
    EXPECT_TRUE(table.interesting({9.5, 9.6}));
    EXPECT_TRUE(table.interesting({1e5, 1e6}));
  }
  // Ranges far away from the points: all values equal the nearer end.
  for (const double far : {1e6, -2e6}) {
    const SampleTable table = tableOf(ramp, VoxelType::f32, {far, far + 1e6});
    EXPECT_NEAR(table.at(static_cast<float>(far + 5e5 - table.offset())).tau, far > 0 ? 1 : 0, 1e-6);
  }
}

// One interval of visible values, also at an end of all values; two intervals; none. Known from all whole values, which
// are the entries of a table of bytes.
TEST(SampleTable, ARangeIsInterestingIfOneOfItsValuesShows) {
  const auto point = [](double value, double opacity) { return TransferPoint{value, {1, 1, 1}, opacity}; };
  const std::vector<TransferPoint> functions[] = {
      {point(0, 0), point(100, 0), point(110, 1), point(130, 1), point(131, 0)},
      {point(0, 1), point(20, 1), point(21, 0)},
      {point(200, 0), point(201, 1)},
      {point(10, 0), point(11, 1), point(12, 0), point(240, 0), point(241, 1)},
      {point(0, 0), point(255, 0)},
      {point(0, 1), point(255, 1)},
  };
  for (const std::vector<TransferPoint>& points : functions) {
    const SampleTable table = tableOf(points);
    for (int lo = 0; lo <= 255; lo += 1) {
      bool shows = false;
      for (int hi = lo; hi <= 255; ++hi) {
        shows = shows || table.at(static_cast<float>(hi - table.offset())).tau > 0;
        ASSERT_EQ(table.interesting({static_cast<double>(lo), static_cast<double>(hi)}), shows) << lo << ' ' << hi;
      }
    }
    EXPECT_FALSE(table.interesting({}));
    EXPECT_EQ(table.interesting({-10, -5}), points.front().opacity > 0);
    EXPECT_EQ(table.interesting({260, 300}), points.back().opacity > 0);
  }
}

// A change that is undone counts twice, and colours count weighted by opacity.
TEST(SampleTable, CountsAllThatChanges) {
  const SampleTable there_and_back =
      tableOf({{100, {1, 1, 1}, ofDepth(0.8)}, {120, {1, 1, 1}, ofDepth(0.2)}, {140, {1, 1, 1}, ofDepth(0.8)}});
  EXPECT_TRUE(there_and_back.soft({100, 120}, 1));
  EXPECT_TRUE(there_and_back.soft({120, 140}, 1));
  EXPECT_FALSE(there_and_back.soft({100, 140}, 1));
  const SampleTable of_colors = tableOf({{100, {1, 0, 0}, ofDepth(3)}, {120, {0, 0, 1}, ofDepth(3)}});
  EXPECT_FALSE(of_colors.soft({90, 130}, 1));
  const SampleTable faint_colors = tableOf({{100, {1, 0, 0}, ofDepth(0.5)}, {120, {0, 0, 1}, ofDepth(0.5)}});
  EXPECT_TRUE(faint_colors.soft({90, 130}, 1));
}

}  // namespace
}  // namespace kiln
