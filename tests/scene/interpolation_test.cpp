// The reference's interpolation is known on polynomials; kernels are compared with the reference
// (engine/ray_lattice_property_test.cpp).
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "support/reference/reference_field.h"

namespace kiln::test {
namespace {

constexpr Interpolation kInterpolations[] = {Interpolation::kLinear, Interpolation::kCubic, Interpolation::kCatmullRom};

// All three filters keep linear functions. On squares the B-spline adds a third, its variance, and Catmull-Rom adds
// nothing.
TEST(ReferenceField, IsKnownOnPolynomials) {
  const DenseVolume slope =
      fill({{9, 9, 9}, VoxelType::f64}, [](auto i, auto j, auto k) { return 3.0 * i - 2.0 * j + 0.5 * k; });
  const DenseVolume square = fill({{9, 9, 9}, VoxelType::f64}, [](auto i, auto j, auto) { return 1.0 * i * i + j; });
  for (const glm::dvec3 at : {glm::dvec3(4, 4, 4), glm::dvec3(3.3, 4.9, 3.5), glm::dvec3(4.75, 3.01, 4.2)}) {
    for (const Interpolation interpolation : kInterpolations) {
      const ReferenceField field(slope, interpolation);
      EXPECT_NEAR(field.at(at), glm::dot(at, glm::dvec3(3, -2, 0.5)), 1e-12);
      EXPECT_LT(glm::length(field.gradient(at) - glm::dvec3(3, -2, 0.5)), 1e-12);
      EXPECT_LT(glm::length(ReferenceField(square, interpolation).gradient(at) - glm::dvec3(2 * at.x, 1, 0)), 1e-12);
    }
    const double exact = at.x * at.x + at.y;
    EXPECT_NEAR(ReferenceField(square, Interpolation::kCubic).at(at), exact + 1.0 / 3, 1e-12);
    EXPECT_NEAR(ReferenceField(square, Interpolation::kCatmullRom).at(at), exact, 1e-12);
  }
}

TEST(ReferenceField, CatmullRomStaysWithinItsVoxels) {
  const DenseVolume step = fill({{9, 9, 9}, VoxelType::f64}, [](auto i, auto, auto) { return i < 4 ? 0.0 : 1.0; });
  const ReferenceField field(step, Interpolation::kCatmullRom);
  EXPECT_EQ(field.at({2.5, 4, 4}), 0);
  EXPECT_EQ(field.at({4.5, 4, 4}), 1);
  EXPECT_EQ(field.at({3.5, 4, 4}), 0.5);
}

}  // namespace
}  // namespace kiln::test
