// The normal with which a sample is lit, and the side of matter.
#include "engine/shared/shade.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

namespace kiln {
namespace {

const glm::vec3 kToEye(0, 0, -1);
// A unit normal with a cosine to the eye.
glm::vec3 normalAt(float cosine) { return {std::sqrt(1 - cosine * cosine), 0, -cosine}; }
glm::vec3 seenAt(float cosine, const GrazingNormal& grazing = {}) {
  return seenNormal(normalAt(cosine), cosine, kToEye, grazing);
}

TEST(SeenNormal, IsTheNormalInFrontOfASilhouette) {
  for (const float cosine : {0.0f, 0.1f, 0.7f, 1.0f}) EXPECT_EQ(seenAt(cosine), normalAt(cosine));
}

TEST(SeenNormal, IsMirroredJustBehindASilhouette) {
  for (const float cosine : {-0.001f, -0.1f, GrazingNormal::kKept}) {
    const glm::vec3 mirrored(normalAt(cosine).x, 0, cosine);
    EXPECT_LT(glm::distance(seenAt(cosine), mirrored), 1e-5f) << cosine;
  }
}

TEST(SeenNormal, IsReversedWhereTheEyeIsInside) {
  for (const float cosine : {GrazingNormal::kReversed, -0.5f, -1.0f}) EXPECT_EQ(seenAt(cosine), -normalAt(cosine));
}

TEST(SeenNormal, OfOpaqueMatterIsMirroredAtEveryCosine) {
  for (const float cosine : {0.0f, -0.1f, -0.5f, -0.9f, -1.0f}) {
    const glm::vec3 mirrored(normalAt(cosine).x, 0, cosine);
    EXPECT_LT(glm::distance(seenAt(cosine, GrazingNormal::ofOpaque()), mirrored), 1e-5f) << cosine;
  }
}

TEST(SeenNormal, TurnsWithoutAJumpAndNeverFromTheEye) {
  constexpr int kSteps = 4000;
  glm::vec3 before = seenAt(0.01f);
  for (int i = 1; i <= kSteps; ++i) {
    const float cosine = 0.01f - 0.4f * static_cast<float>(i) / kSteps;
    const glm::vec3 seen = seenAt(cosine);
    EXPECT_NEAR(glm::length(seen), 1, 1e-5f);
    EXPECT_GE(glm::dot(seen, kToEye), -1e-6f);
    EXPECT_LT(glm::distance(seen, before), 0.02f) << cosine;
    before = seen;
  }
}

TEST(OutsidesOnly, AreSeenOfOpaqueLabelsAndSurfaces) {
  const glm::dvec3 white(1);
  const auto labels = [&](double first, double second, double unit) {
    TransferFunction out;
    out.unit = unit;
    out.labels = {{1, "", white, first}, {2, "", white, second}};
    return showsOutsidesOnly(out, 0.5);
  };
  EXPECT_TRUE(labels(1, 1, 0));
  EXPECT_TRUE(labels(1, 0, 0.5));
  EXPECT_FALSE(labels(1, 0.9, 0));
  EXPECT_FALSE(labels(1, 1, 0.6)) << "a voxel is translucent";
  TransferFunction surfaces;
  surfaces.surfaces = {{10, white, 1}, {20, white, 1}};
  EXPECT_TRUE(showsOutsidesOnly(surfaces, 0.5));
  surfaces.surfaces[0].opacity = 0.5;
  EXPECT_FALSE(showsOutsidesOnly(surfaces, 0.5));
  EXPECT_FALSE(showsOutsidesOnly({0, {{10, white, 0}, {20, white, 1}}}, 0.5));
}

TEST(OutwardSign, IsOfTheTransparentEnd) {
  const glm::dvec3 white(1);
  EXPECT_EQ(outwardSignOf({0, {{10, white, 0}, {20, white, 1}}}), -1);
  EXPECT_EQ(outwardSignOf({0, {{10, white, 1}, {20, white, 0.1}}}), 1);
  EXPECT_EQ(outwardSignOf({0, {{10, white, 0}, {20, white, 1}, {30, white, 0}}}), -1);
  TransferFunction surfaces;
  surfaces.surfaces = {{100, white, 1}};
  EXPECT_EQ(outwardSignOf(surfaces), -1);
}

}  // namespace
}  // namespace kiln
