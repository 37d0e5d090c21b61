// The lattice that a zone of depth has: samples between half a pixel and a pixel apart wherever the pyramid has a level
// for it (in perspective, half a pixel less an eighth), zones that follow each other without a gap, and levels that do
// not fall on the way.
#include "splat/slab_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "grid/pyramid.h"

namespace kiln::test {
namespace {

Manifest pyramid(const glm::dvec3& spacing) {
  VolumeGeometry volume;
  volume.dims = {1024, 1024, 1024};
  for (int a = 0; a < 3; ++a) volume.world_from_index[a][a] = spacing[a];
  Manifest out;
  for (const VolumeGeometry& level : pyramidOf(volume, 16, 16)) out.levels.push_back({level, {1, 1, 1}});
  return out;
}

// From before the volume's middle, so far away that a voxel there is `px_per_voxel`.
View viewAt(const Manifest& volume, Projection projection, double px_per_voxel) {
  const VolumeGeometry& g = volume.geometry();
  const double depth = 3 * g.spacing().z * static_cast<double>(g.dims.z);
  View out;
  out.projection = projection;
  out.size = {512, 512};
  out.view_from_world[3] = glm::dvec4(-g.worldOf({511.5, 511.5, 511.5}) + glm::dvec3(0, 0, depth), 1);
  const glm::dvec3 s = g.spacing();
  out.focal_px = px_per_voxel / std::min({s.x, s.y, s.z}) * (projection == Projection::kPerspective ? depth : 1);
  return out;
}

// Of a zone's samples, along the axis where they are nearest to each other. unit: pixels, where they are seen largest.
double spacing(const SlabZone& zone, const Manifest& volume, const View& view) {
  const glm::dvec3 edges = volume.levels[static_cast<std::size_t>(zone.level)].geometry.spacing();
  double least = INFINITY;
  for (int a = 0; a < 3; ++a)
    least = std::min(least, edges[a] / zone.refinement[static_cast<std::size_t>(a)].ofVoxel());
  return least * view.focal_px / (view.projection == Projection::kPerspective ? zone.near : 1);
}

TEST(SlabGrid, SamplesAreBetweenHalfAPixelAndAPixelApart) {
  for (const glm::dvec3& voxel : {glm::dvec3(1), glm::dvec3(0.7, 0.7, 0.9), glm::dvec3(0.5, 0.5, 2)}) {
    const Manifest volume = pyramid(voxel);
    for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
      for (double px = 0.05; px < 8; px *= 1.05) {
        SCOPED_TRACE(testing::Message() << px << " pixels a voxel of " << voxel.z);
        const View view = viewAt(volume, projection, px);
        const std::vector<SlabZone> zones = slabZones({&volume, 1e-3}, view, {});
        ASSERT_FALSE(zones.empty());
        int level = 0;
        double near = zones.front().near;
        for (const SlabZone& zone : zones) {
          const double apart = spacing(zone, volume, view);
          EXPECT_GE(apart, 0.4375 - 1e-9);
          EXPECT_LE(apart, 1 + 1e-9);
          EXPECT_GE(zone.level, level);
          EXPECT_DOUBLE_EQ(zone.near, near);
          EXPECT_NEAR(zone.far, zone.near + zone.slabs * zone.thickness, 1e-9 * zone.far);
          level = zone.level, near = zone.far;
        }
      }
    }
  }
}

// Between samples of what is not steep is nearly their mean: fewer do, down to one and three eighths a voxel.
TEST(SlabGrid, SamplesOfSoftFunctionsAreFewer) {
  const Manifest volume = pyramid(glm::dvec3(1));
  for (const double px : {0.5, 1.0, 1.27, 2.0, 6.0}) {
    const View view = viewAt(volume, Projection::kOrthographic, px);
    const auto apart = [&](double steepness) {
      return spacing(slabZones({&volume, 1e-3, steepness}, view, {}).front(), volume, view);
    };
    EXPECT_DOUBLE_EQ(apart(1.001), apart(INFINITY));
    EXPECT_GE(apart(1), apart(INFINITY));
    if (px > 0.7) {
      EXPECT_NEAR(apart(1), std::min(1.0, px * 8 / 11), 0.05) << px;
    }
  }
}

// Half a pixel a voxel in the middle, and less behind it: one level all the same.
TEST(SlabGrid, HalfAPixelAVoxelIsOfOneLevel) {
  const Manifest volume = pyramid(glm::dvec3(1));
  const View view = viewAt(volume, Projection::kPerspective, 0.5);
  const double middle = 3.0 * 1024;
  bool behind_the_middle = false;
  for (const SlabZone& zone : slabZones({&volume, 1e-3}, view, {})) {
    const double voxel_px = view.focal_px / zone.near;
    EXPECT_EQ(zone.level, voxel_px < 0.4375 ? 1 : 0) << voxel_px;
    behind_the_middle = behind_the_middle || (voxel_px > 0.4375 && zone.near > middle);
  }
  EXPECT_TRUE(behind_the_middle);
}

}  // namespace
}  // namespace kiln::test
