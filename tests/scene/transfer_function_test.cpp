// Known answers: between points the function is a straight line, so its middle is the mean of its ends; sRGB's 8-bit
// middle grey 188 is 50.3 % light.
#include "scene/transfer/transfer_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/srgb.h"

namespace kiln {
namespace {

TransferFunction ramp() { return {1, {{10, {1, 0, 0}, 0}, {20, {0, 1, 0}, 0.5}, {40, {0, 0, 1}, 0.1}}}; }

TEST(TransferFunction, IsLinearBetweenPointsAndHoldsOutside) {
  const TransferFunction f = ramp();
  EXPECT_EQ(f.at(15).color, glm::dvec3(0.5, 0.5, 0));
  EXPECT_EQ(f.at(15).opacity, 0.25);
  EXPECT_NEAR(f.at(30).opacity, 0.3, 1e-15);
  EXPECT_EQ(f.at(20).color, glm::dvec3(0, 1, 0));
  EXPECT_EQ(f.at(-5).color, glm::dvec3(1, 0, 0));
  EXPECT_EQ(f.at(1e9).opacity, 0.1);
  EXPECT_EQ(f.at(std::numeric_limits<double>::infinity()).opacity, 0.1);
  EXPECT_EQ(f.at(-std::numeric_limits<double>::infinity()).opacity, 0);
}

// A value is inside a surface from the surface's value on.
TEST(TransferFunction, SurfacesAreCrossedBetweenOutsideAndInside) {
  TransferFunction f;
  f.surfaces = {{5}, {10, glm::dvec3(1), 0}};
  EXPECT_TRUE(f.surfacesCrossedIn(4, 5));
  EXPECT_TRUE(f.surfacesCrossedIn(-20, 20));
  EXPECT_FALSE(f.surfacesCrossedIn(5, 20));
  EXPECT_FALSE(f.surfacesCrossedIn(0, 4.9));
  EXPECT_FALSE(f.interesting(5));
}

TEST(TransferFunction, NanAndNoPointsAreTransparent) {
  EXPECT_EQ(ramp().at(std::nan("")).opacity, 0);
  EXPECT_FALSE(ramp().interesting(std::nan("")));
  EXPECT_EQ(TransferFunction{}.at(3).opacity, 0);
}

TEST(TransferFunction, AStepTakesTheLastPointFromItsValueOn) {
  const TransferFunction f{1, {{0, {0, 0, 0}, 0}, {5, {0, 0, 0}, 0}, {5, {1, 1, 1}, 0.3}, {5, {1, 0, 0}, 0.8}}};
  EXPECT_EQ(f.at(std::nextafter(5.0, 0.0)).opacity, 0);
  EXPECT_EQ(f.at(5).opacity, 0.8);
  EXPECT_EQ(f.at(5).color, glm::dvec3(1, 0, 0));
  const TransferFunction at_start{1, {{5, {0, 0, 0}, 0.1}, {5, {1, 1, 1}, 0.9}}};
  EXPECT_EQ(at_start.at(4).opacity, 0.1);
  EXPECT_EQ(at_start.at(5).opacity, 0.9);
}

TEST(TransferFunction, InterestingIsAnyOpacityAtAll) {
  EXPECT_FALSE(ramp().interesting(10));
  EXPECT_TRUE(ramp().interesting(10.001));
}

// Twice the unit halves the extinction; 1 - e^-2 of opacity is an optical depth of 2; full opacity is clamped.
TEST(TransferFunction, OpacityIsPerUnitOfLength) {
  EXPECT_NEAR(extinctionOf(1 - std::exp(-2.0), 1), 2, 1e-12);
  EXPECT_NEAR(extinctionOf(1 - std::exp(-2.0), 2), 1, 1e-12);
  EXPECT_NEAR(extinctionOf(1, 1), -std::log(1e-4), 1e-9);
  EXPECT_EQ(extinctionOf(0, 1), 0);
}

TEST(TransferFunction, SrgbCurvesAreInverse) {
  EXPECT_NEAR(linearFromSrgb(188 / 255.0), 0.5029, 1e-4);
  EXPECT_EQ(linearFromSrgb(0), 0);
  EXPECT_NEAR(linearFromSrgb(1), 1, 1e-15);
  for (int i = 0; i <= 1000; ++i) EXPECT_NEAR(srgbFromLinear(linearFromSrgb(i / 1000.0)), i / 1000.0, 1e-7);
}

}  // namespace
}  // namespace kiln
