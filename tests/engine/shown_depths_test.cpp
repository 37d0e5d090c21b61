// Known answers: bounds of a ramp, of a step, of labels and of surfaces, by the definition of each.
#include "engine/shown_depths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace kiln {
namespace {

const glm::dvec3 kWhite(1);

double opacityIn(const TransferFunction& function, const ValueRange& range) {
  const ShownDepths shown(std::vector{function}, 1, {-1000, 1000}, Progress());
  return -std::expm1(-shown.depth(range, 1));
}

TEST(ShownDepths, OfPoints_areTheMostOpaqueValues) {
  const TransferFunction ramp{0, {{100, kWhite, 0}, {200, kWhite, 0.5}, {300, kWhite, 0.1}}};
  EXPECT_EQ(opacityIn(ramp, {-500, 99.9}), 0);
  EXPECT_NEAR(opacityIn(ramp, {150, 150}), 0.25, 0.002);
  EXPECT_NEAR(opacityIn(ramp, {150, 250}), 0.5, 0.002);
  EXPECT_NEAR(opacityIn(ramp, {400, 900}), 0.1, 0.002);
  EXPECT_EQ(opacityIn(ramp, {}), 0);
}

// For any function, no value of a range is more opaque than the bound.
TEST(ShownDepths, OfPoints_areBounds) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> value(-900, 900), share(0, 0.9);
  for (int n = 0; n < 200; ++n) {
    TransferFunction function;
    for (int i = 0; i <= n % 6; ++i) function.points.push_back({value(random), kWhite, i % 2 == 0 ? 0 : share(random)});
    std::ranges::sort(function.points, {}, &TransferPoint::value);
    const ShownDepths shown(std::vector{function}, 1, {-1000, 1000}, Progress());
    for (int i = 0; i < 50; ++i) {
      const double a = value(random), b = value(random), in = std::lerp(a, b, share(random));
      EXPECT_GE(-std::expm1(-shown.depth({std::min(a, b), std::max(a, b)}, 1)), function.at(in).opacity - 1e-6);
    }
  }
}

TEST(ShownDepths, OfLabels_areThoseOfTheLabelsInside) {
  TransferFunction function;
  function.labels = {{3, "", kWhite, 0.2}, {7, "", kWhite, 0.9}};
  EXPECT_NEAR(opacityIn(function, {3, 7}), 0.9, 1e-6);
  EXPECT_NEAR(opacityIn(function, {1, 6}), 0.2, 1e-6);
  EXPECT_EQ(opacityIn(function, {4, 6}), 0);
  const ShownDepths shown(std::vector{function}, 1, {0, 10}, Progress());
  EXPECT_EQ(shown.depth(shown.binOf(5), shown.binOf(5), 1), 0);
}

TEST(ShownDepths, OfSurfaces_areThoseThatAreCrossed) {
  TransferFunction function;
  function.surfaces = {{100, kWhite, 0.25}, {200, kWhite, 0.5}};
  EXPECT_NEAR(opacityIn(function, {50, 150}), 0.25, 1e-6);
  EXPECT_NEAR(opacityIn(function, {50, 250}), 0.5, 1e-6);
  EXPECT_EQ(opacityIn(function, {110, 190}), 0);
  EXPECT_EQ(opacityIn(function, {100, 100}), 0) << "values of a surface and above are inside";
}

TEST(ShownDepths, MissingValues_areNone) {
  const TransferFunction ramp{0, {{100, kWhite, 0}, {200, kWhite, 0.5}}};
  const ShownDepths shown(std::vector{ramp}, 1, {0, 255}, Progress());
  EXPECT_EQ(shown.binOf(std::numeric_limits<double>::quiet_NaN()), ShownDepths::kNone);
  EXPECT_EQ(shown.binOf(-std::numeric_limits<double>::infinity()), 0);
  EXPECT_GT(shown.depth(shown.binOf(1e300), shown.binOf(std::numeric_limits<double>::infinity()), 1), 0.6);
}

}  // namespace
}  // namespace kiln
