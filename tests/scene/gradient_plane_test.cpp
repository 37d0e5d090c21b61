// Factors over values and gradients: known from the definition of the shapes.
#include <gtest/gtest.h>

#include "scene/transfer/transfer_function.h"
#include "scene/transfer/transfer_function_fade.h"

namespace kiln::test {
namespace {

GradientRegion rectangle() {
  GradientRegion out;
  out.values = {100, 200}, out.gradients = {10, 30}, out.opacity = 0.8, out.softness = 0.4;
  return out;
}

TEST(GradientRegion, Rectangle_risesFromItsEdges) {
  const GradientRegion r = rectangle();
  EXPECT_EQ(r.at(150, 20), 0.8);
  EXPECT_EQ(r.at(99, 20), 0);
  EXPECT_EQ(r.at(150, 9), 0);
  EXPECT_EQ(r.at(150, 31), 0);
  EXPECT_DOUBLE_EQ(r.at(110, 20), 0.4);  // half of a rise of 20 values
  EXPECT_DOUBLE_EQ(r.at(150, 12), 0.4);  // half of a rise of 4
  EXPECT_DOUBLE_EQ(r.at(190, 28), 0.2);
}

TEST(GradientRegion, EdgeAtGradientZero_isNotSoft) {
  GradientRegion r = rectangle();
  r.gradients = {0, 30};
  EXPECT_EQ(r.at(150, 0), 0.8);
}

TEST(GradientRegion, WithoutSoftness_hasEqualOpacity) {
  GradientRegion r = rectangle();
  r.softness = 0;
  for (const double value : {100.0, 150.0, 200.0}) {
    for (const double gradient : {10.0, 20.0, 30.0}) EXPECT_EQ(r.at(value, gradient), 0.8);
  }
}

TEST(GradientRegion, Triangle_widensWithTheGradient) {
  GradientRegion r = rectangle();
  r.shape = RegionShape::kTriangle;
  EXPECT_EQ(r.at(150, 20), 0.8);
  EXPECT_EQ(r.at(124, 20), 0);  // the half width is 25
  EXPECT_DOUBLE_EQ(r.at(130, 20), 0.4);
  EXPECT_EQ(r.at(101, 29), 0);
  EXPECT_GT(r.at(104, 29.9), 0);
}

TEST(GradientTable, IsLinearBetweenNodes) {
  const GradientTable table{{0, 10}, {0, 4}, 3, 2, {0, 0.5f, 1, 1, 0, 1}};
  EXPECT_EQ(table.at(0, 0), 0);
  EXPECT_EQ(table.at(5, 0), 0.5);
  EXPECT_EQ(table.at(5, 4), 0);
  EXPECT_DOUBLE_EQ(table.at(2.5, 0), 0.25);
  EXPECT_DOUBLE_EQ(table.at(2.5, 2), 0.375);
  EXPECT_EQ(table.at(-7, 9), 1);  // the last nodes extend
}

TEST(TransferFunctionPlane, RegionsThatOverlap_mixColoursAndHaveTheGreatestFactor) {
  TransferFunction f{1, {{0, {1, 1, 1}, 0.5}}};
  GradientRegion red = rectangle(), own = rectangle();
  red.color = glm::dvec3(1, 0, 0);
  own.opacity = 0.2;
  f.regions = {red, own};
  const Classified c = f.at(150, 20);
  EXPECT_DOUBLE_EQ(c.opacity, 0.4);
  EXPECT_DOUBLE_EQ(c.color.r, 1);
  EXPECT_DOUBLE_EQ(c.color.g, 0.2);
  EXPECT_EQ(f.at(0, 20).opacity, 0);
}

TEST(TransferFunctionPlane, LengthsFollowTheWorld) {
  TransferFunction f{1, {{0, {1, 1, 1}, 1}}};
  f.regions = {rectangle()};
  const TransferFunction in_millimetres = inWorld(f, 1000);
  EXPECT_DOUBLE_EQ(in_millimetres.gradientFactor(150, 0.02), 0.8);
}

TEST(TransferFunctionPlane, RegionsFade) {
  TransferFunction a{1, {{0, {1, 1, 1}, 1}}}, b = a;
  a.regions = {rectangle()};
  b.regions = {rectangle()};
  b.regions[0].values = {300, 400};
  const TransferFunction half = faded(a, b, 0.25);
  EXPECT_DOUBLE_EQ(half.gradientFactor(150, 20), 0.6);
  EXPECT_DOUBLE_EQ(half.gradientFactor(350, 20), 0.2);
}

// A medium turns light, it does not make light: the mean over all directions is 1.
TEST(Scattering, Phase_hasAMeanOfOne) {
  for (const double g : {-0.9, -0.3, 0.0, 0.5, 0.9}) {
    const Scattering scattering{1, g};
    constexpr int kSteps = 20000;
    double sum = 0, cosines = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = -1 + (i + 0.5) * 2 / kSteps;
      sum += scattering.phase(cosine) / kSteps;
      cosines += cosine * scattering.phase(cosine) / kSteps;
    }
    EXPECT_NEAR(sum, 1, 1e-4) << g;
    EXPECT_NEAR(cosines, g, 1e-4) << g;
  }
}

}  // namespace
}  // namespace kiln::test
