// Known answers: a box of voxels holds exactly its voxels, on every level the voxels with centres inside. A plane
// through known world points divides them; a box is classified as all its points.
#include "scene/clip_region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "support/system/expect_error.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

VolumeGeometry volumeOf(const Extent3& dims) {
  VolumeGeometry out;
  out.dims = dims;
  return out;
}

TEST(ClipRegion, NothingSaidShowsEverything) {
  EXPECT_TRUE(ClipRegion().showsAll());
  EXPECT_TRUE(ClipRegion({}, volumeOf({4, 4, 4})).showsAll());
  EXPECT_TRUE(ClipRegion({VoxelBox{{0, -5, 0}, {4, 4, 90}}, {}}, volumeOf({4, 4, 4})).showsAll());
  EXPECT_EQ(ClipRegion().classify({{0, 0, 0}, {9, 9, 9}}), ClipRegion::Overlap::kInside);
  EXPECT_EQ(ClipRegion().cutGradient({0, 0, 0}, {1, 1, 1}), nullptr);
}

TEST(ClipRegion, ABoxOfVoxelsHoldsItsVoxels) {
  const VoxelBox box{{2, 0, 1}, {5, 6, 7}};
  const ClipRegion region({box, {}}, volumeOf({8, 6, 9}));
  for (std::int64_t z = 0; z < 9; ++z) {
    for (std::int64_t y = 0; y < 6; ++y) {
      for (std::int64_t x = 0; x < 8; ++x) EXPECT_EQ(region.contains({x, y, z}), box.contains({x, y, z}));
    }
  }
}

// Returns the share of a segment inside the region. `index` is the segment's middle, `along` its extent.
double shareInside(const ClipRegion& region, const glm::dvec3& index, const glm::dvec3& along) {
  double begin = -0.5, end = 0.5;
  region.cutLine(index, along, begin, end);
  return std::max(end - begin, 0.0);
}

// A coarse voxel whose centre lies on the shared face of two regions is in exactly one of them.
TEST(ClipRegion, RegionsThatShareAFaceShareNoVoxelOfAnyLevel) {
  const VolumeGeometry volume = volumeOf({24, 24, 24});
  for (const Extent3& span : {Extent3{1, 1, 1}, Extent3{2, 2, 2}, Extent3{8, 4, 1}}) {
    for (std::int64_t cut = 1; cut < 24; ++cut) {
      const ClipRegion left({VoxelBox{{0, 0, 0}, {cut, 24, 24}}, {}}, volume, span);
      const ClipRegion right({VoxelBox{{cut, 0, 0}, {24, 24, 24}}, {}}, volume, span);
      for (std::int64_t x = 0; x < 24 / span.x; ++x) EXPECT_NE(left.contains({x, 1, 1}), right.contains({x, 1, 1}));
    }
  }
}

// 13 samples per 8 voxels lie across most faces. The shares of two adjacent regions sum to the whole sample, and the
// shares of a region sum to its width.
TEST(ClipRegion, SharesOfSamplesAddUp) {
  constexpr double kEdge = 8.0 / 13;
  for (std::int64_t face = 1; face < 16; ++face) {
    const ClipRegion below({VoxelBox{{0, 0, 0}, {face, 4, 4}}, {}}, volumeOf({16, 4, 4}));
    const ClipRegion above({VoxelBox{{face, 0, 0}, {16, 4, 4}}, {}}, volumeOf({16, 4, 4}));
    double width = 0;
    for (int i = 0; i < 26; ++i) {
      const glm::dvec3 index((i + 0.5) * kEdge - 0.5, 1, 1);
      const glm::dvec3 along(i % 2 == 0 ? kEdge : -kEdge, 0.1, 0);
      const double share = shareInside(below, index, along);
      EXPECT_NEAR(share + shareInside(above, index, along), 1, 1e-12);
      width += share * kEdge;
    }
    EXPECT_NEAR(width, static_cast<double>(face), 1e-12);
    for (std::int64_t x = 0; x < 16; ++x)
      EXPECT_EQ(shareInside(below, {x, 1, 1}, glm::dvec3(1, 0, 0)), x < face ? 1 : 0) << "whole voxels";
  }
}

// An interval across both faces of a thin plate has the plate's thickness inside.
TEST(ClipRegion, APlateHasTheShareOfItsThickness) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 2, -1));
  for (const double thickness : {1e-6, 1e-3, 0.2}) {
    const double middle = glm::dot(normal, glm::dvec3(8, 8, 8));
    const ClipRegion plate({{}, {{normal, thickness / 2 - middle}, {-normal, thickness / 2 + middle}}},
                           volumeOf({16, 16, 16}));
    EXPECT_NEAR(shareInside(plate, {8, 8, 8}, normal), thickness, 1e-12);
    EXPECT_NEAR(shareInside(plate, {8, 8, 8}, 2.0 * normal), thickness / 2, 1e-12);
    EXPECT_EQ(shareInside(plate, glm::dvec3(8, 8, 8) + normal, normal), 0);
  }
}

TEST(ClipRegion, APlaneDividesTheWorldWhateverTheAffineAndTheLevel) {
  VolumeGeometry volume = volumeOf({32, 32, 32});
  volume.world_from_index = obliqueAffine();
  const glm::dvec3 normal(3, -2, 1.5);
  const ClipPlane plane{normal, -glm::dot(normal, volume.worldOf({11, 12, 13}))};
  for (const Extent3& span : {Extent3{1, 1, 1}, Extent3{4, 2, 2}}) {
    const ClipRegion region({std::nullopt, {plane}}, volume, span);
    int inside = 0;
    for (int i = 0; i < 4096; ++i) {
      const glm::dvec3 index(i % 16, i / 16 % 16, i / 256);
      const glm::dvec3 scale(span.x, span.y, span.z);
      const double value = glm::dot(plane.normal, volume.worldOf(scale * index + 0.5 * (scale - 1.0))) + plane.offset;
      EXPECT_TRUE(std::abs(value) < 1e-9 || region.contains(index) == (value > 0)) << i;
      inside += region.contains(index) ? 1 : 0;
    }
    EXPECT_GT(inside, 200);
    EXPECT_LT(inside, 3900);
  }
}

// Classification of a box of voxels against many of its points, cut voxels included.
TEST(ClipRegion, ABoxIsClassifiedAsItsPointsAre) {
  VolumeGeometry volume = volumeOf({40, 40, 40});
  volume.world_from_index = obliqueAffine();
  const glm::dvec3 centre = volume.worldOf({20, 20, 20});
  const glm::dvec3 normals[] = {{1, 0.2, -0.4}, {-0.3, 1, 0.9}};
  const Clipping clipping{
      VoxelBox{{3, 4, 0}, {33, 40, 38}},
      {{normals[0], -glm::dot(normals[0], centre) + 4}, {normals[1], 6 - glm::dot(normals[1], centre)}}};
  const ClipRegion region(clipping, volume);
  int seen[3] = {};
  for (std::int64_t z = 0; z < 40; z += 4) {
    for (std::int64_t y = 0; y < 40; y += 4) {
      for (std::int64_t x = 0; x < 40; x += 4) {
        const ClipRegion::Overlap overlap = region.classify({{x, y, z}, {x + 4, y + 4, z + 4}});
        ++seen[static_cast<int>(overlap)];
        for (int i = 0; i < 1000; ++i) {
          const glm::dvec3 p = glm::dvec3(x, y, z) - 0.499 + 0.444 * glm::dvec3(i % 10, i / 10 % 10, i / 100);
          EXPECT_FALSE(overlap == ClipRegion::Overlap::kOutside && region.contains(p));
          // Each face looks at one of the eyes.
          for (const glm::dvec3& to_eye : {glm::dvec3(1, 1, 1), glm::dvec3(-1, -1, -1)}) {
            EXPECT_FALSE(overlap == ClipRegion::Overlap::kInside &&
                         !(region.contains(p) && region.cutGradient(p, to_eye) == nullptr));
          }
        }
      }
    }
  }
  for (const int count : seen) EXPECT_GT(count, 50);
}

// The first layer of voxels behind a face has the face's normal, the second none; in a corner the nearer face wins.
TEST(ClipRegion, TheFirstVoxelsBehindAFaceHaveItsNormal) {
  const ClipRegion region({VoxelBox{{2, 0, 0}, {8, 5, 8}}, {{{0, 0, 2}, -5.0}}}, volumeOf({8, 8, 8}));
  // All faces look at the eye, from equal sides.
  const auto normalAt = [&](const glm::dvec3& index) {
    const glm::vec3* gradient = region.cutGradient(index, {-1, 1, -1});
    return gradient == nullptr ? glm::vec3(0) : *gradient;
  };
  EXPECT_EQ(normalAt({2, 2, 5}), glm::vec3(1, 0, 0));
  EXPECT_EQ(normalAt({3, 2, 5}), glm::vec3(0));
  EXPECT_EQ(normalAt({5, 4, 5}), glm::vec3(0, -1, 0));
  EXPECT_EQ(normalAt({5, 3, 5}), glm::vec3(0));
  EXPECT_EQ(normalAt({5, 2, 3}), glm::vec3(0, 0, 1));
  EXPECT_EQ(normalAt({5, 2, 4}), glm::vec3(0));
  EXPECT_EQ(normalAt({2, 2, 2.7}), glm::vec3(0, 0, 1));
  EXPECT_EQ(normalAt({1.6, 2, 2.7}), glm::vec3(1, 0, 0));
}

// A face seen edge-on has no side that faces the eye, whatever the rounding of the view.
TEST(ClipRegion, AFaceSeenEdgeOnLightsNoSample) {
  const ClipRegion region({std::nullopt, {{{0, 0, 2}, -5.0}}}, volumeOf({8, 8, 8}));
  const glm::dvec3 sample(4, 4, 2.51);  // nearer to the face than to the border of the volume, along all directions
  for (const double along : {1e-9, 0.0, -1e-9}) EXPECT_EQ(region.cutGradient(sample, {0, 300, 300 * along}), nullptr);
  EXPECT_EQ(region.cutGradient(sample, {0, 300, 3}), nullptr) << "the face looks away";
  ASSERT_NE(region.cutGradient(sample, {0, 300, -3}), nullptr);
  EXPECT_EQ(*region.cutGradient(sample, {0, 300, -3}), glm::vec3(0, 0, 1));
}

// The border of the volume has faces of its own, at every level, and clips nothing.
TEST(ClipRegion, BorderOfTheVolume_isLitAsAFace) {
  const VolumeGeometry volume = volumeOf({9, 8, 8});
  for (const std::int64_t span : {1, 2}) {
    const ClipRegion whole({}, volume, {span, span, span});
    EXPECT_TRUE(whole.showsAll());
    EXPECT_TRUE(whole.halfSpaces().empty());
    const auto normalAt = [&](const glm::dvec3& index) {
      const double side = index.x > 2 ? 1 : -1;  // the eye's
      const glm::vec3* gradient = whole.cutGradient(index, glm::dvec3(side));
      return gradient == nullptr ? glm::vec3(0) : *gradient;
    };
    const double end = 9.0 / static_cast<double>(span) - 0.5;
    EXPECT_EQ(normalAt({0.4, 1.5, 1.5}), glm::vec3(1, 0, 0));
    EXPECT_EQ(normalAt({0.6, 1.5, 1.5}), glm::vec3(0));
    EXPECT_EQ(normalAt({end - 0.9, 1.5, 1.5}), glm::vec3(-1, 0, 0));
    EXPECT_EQ(normalAt({end - 1.1, 1.5, 1.5}), glm::vec3(0));
    EXPECT_EQ(normalAt({0.4, 1.5, 0.2}), glm::vec3(0, 0, 1));
    EXPECT_EQ(whole.classify({{0, 1, 1}, {1, 2, 2}}), ClipRegion::Overlap::kCut);
    EXPECT_EQ(whole.classify({{1, 1, 1}, {3, 3, 3}}), ClipRegion::Overlap::kInside);
  }
}

TEST(ClipRegion, ARegionOutsideOfTheVolumeIsRefused) {
  expectError(
      [&] {
        ClipRegion({VoxelBox{{8, 0, 0}, {9, 8, 8}}, {}}, volumeOf({8, 8, 8}));
      },
      ErrorCode::kUsage, "8,0,0 to 9,8,8");
}

}  // namespace
}  // namespace kiln::test
