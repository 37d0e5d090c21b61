// A footprint table holds Gaussians that sum to 1 over exactly the pixels inside the footprint.
#include "engine/voxel/voxel_footprint.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kiln::test {
namespace {

// Returns the ellipse of a Gaussian with these standard deviations along the picture's axes.
Ellipse ellipseOf(double sigma_x, double sigma_y) {
  Ellipse out;
  out.a = static_cast<float>(1 / (sigma_x * sigma_x)), out.c = static_cast<float>(1 / (sigma_y * sigma_y));
  out.half_x = static_cast<float>(kFootprintRadius * sigma_x),
  out.half_y = static_cast<float>(kFootprintRadius * sigma_y);
  return out;
}

void expectGaussians(const float* row, int pixels, int phase, double half) {
  SCOPED_TRACE(::testing::Message() << "phase " << phase << " of " << half << " pixels");
  const double sigma = half / kFootprintRadius, part = 1.0 / VoxelFootprint::kPhases;
  const double first = (phase + 0.5) * part - half;
  const auto gaussian = [&](int i) { return std::exp(-0.5 * std::pow((first + i) / sigma, 2)); };
  double sum = 0;
  for (int i = 0; i < pixels; ++i) {
    const auto weight = static_cast<double>(row[i]);
    sum += weight;
    // For every phase of the first pixel, weights beyond the half width are zero, and weights well inside are not.
    if (first + 0.5 * part + i > half) {
      EXPECT_EQ(weight, 0) << i;
    }
    if (first + part + i < half) {
      const auto of_first = static_cast<double>(row[0]);
      EXPECT_NEAR(weight / of_first, gaussian(i) / gaussian(0), 1e-5 / of_first) << i;
    }
  }
  EXPECT_NEAR(sum, 1, 1e-6);
}

TEST(VoxelFootprint, IsAProductOfGaussians) {
  for (const double sigma : {0.37, 0.62, 1.0, 1.3}) {
    const Ellipse ellipse = ellipseOf(sigma, 2 * sigma);
    ASSERT_TRUE(VoxelFootprint::fits(ellipse));
    const VoxelFootprint footprint(ellipse);
    for (int phase = 0; phase < VoxelFootprint::kPhases; ++phase) {
      expectGaussians(footprint.columns(phase), VoxelFootprint::kColumns, phase, 3 * sigma);
      expectGaussians(footprint.rows(phase), VoxelFootprint::kRows, phase, 6 * sigma);
      for (int i = 0; i < VoxelFootprint::kBeside; ++i) {
        EXPECT_EQ(footprint.columns(phase)[-1 - i], 0);
        EXPECT_EQ(footprint.columns(phase)[VoxelFootprint::kColumns + i], 0);
      }
    }
  }
}

TEST(VoxelFootprint, HasThePhaseOfItsFirstPixel) {
  EXPECT_EQ(VoxelFootprint::phaseOf(-2.0f, 2.0f), 0);
  EXPECT_EQ(VoxelFootprint::phaseOf(-1.5f, 2.0f), VoxelFootprint::kPhases / 2);
  EXPECT_EQ(VoxelFootprint::phaseOf(-1.0001f, 2.0f), VoxelFootprint::kPhases - 1);
  // Phases at the ends are clamped after rounding.
  EXPECT_EQ(VoxelFootprint::phaseOf(-2.0001f, 2.0f), 0);
  EXPECT_EQ(VoxelFootprint::phaseOf(-1.0f, 2.0f), VoxelFootprint::kPhases - 1);
}

TEST(VoxelFootprint, IsForStraightEllipsesOfItsSize) {
  EXPECT_FALSE(VoxelFootprint::fits(ellipseOf(1.34, 1)));
  EXPECT_FALSE(VoxelFootprint::fits(ellipseOf(1, 2.67)));
  Ellipse oblique = ellipseOf(1, 1);
  EXPECT_TRUE(VoxelFootprint::fits(oblique));
  oblique.b = 1e-3f;
  EXPECT_FALSE(VoxelFootprint::fits(oblique));
}

}  // namespace
}  // namespace kiln::test
