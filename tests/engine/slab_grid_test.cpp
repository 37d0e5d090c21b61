// Slabs of a zone of depth: thickness between half a pixel and a pixel by default. Zones follow each other without a
// gap, and levels never fall with depth.
#include "engine/shared/slab_grid.h"

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

// Returns a view from in front of the volume's middle, at the distance where a voxel is `px_per_voxel` pixels wide.
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

// Returns the thickness of a zone's slabs where their projection is largest. unit: pixels.
double thicknessPx(const SlabZone& zone, const View& view) {
  return zone.thickness * view.focal_px / (view.projection == Projection::kPerspective ? zone.near : 1);
}

TEST(SlabGrid, SlabsAreBetweenHalfAPixelAndAPixelThick) {
  for (const glm::dvec3& voxel : {glm::dvec3(1), glm::dvec3(0.7, 0.7, 0.9), glm::dvec3(0.5, 0.5, 2)}) {
    const Manifest volume = pyramid(voxel);
    for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
      for (double px = 0.05; px < 2.4; px *= 1.05) {
        SCOPED_TRACE(testing::Message() << px << " pixels a voxel of " << voxel.z);
        const View view = viewAt(volume, projection, px);
        const std::vector<SlabZone> zones = slabZones({&volume, 1e-3}, view, {});
        ASSERT_FALSE(zones.empty());
        int level = 0;
        double near = zones.front().near;
        for (const SlabZone& zone : zones) {
          // Whole slabs fill a zone.
          const double rounding = projection == Projection::kPerspective ? 0.5 / zone.slabs : 1e-9;
          EXPECT_GE(thicknessPx(zone, view), 0.5 * (1 - rounding));
          EXPECT_LE(thicknessPx(zone, view), 1 + rounding);
          EXPECT_GE(zone.level, level);
          EXPECT_DOUBLE_EQ(zone.near, near);
          EXPECT_NEAR(zone.far, zone.near + zone.slabs * zone.thickness, 1e-9 * zone.far);
          level = zone.level, near = zone.far;
        }
      }
    }
  }
}

// Zones of a far eye are much deeper than the volume; slabs about the volume stay as thick as samples need.
TEST(SlabGrid, SlabsOfAFarEyeAreNoThicker) {
  const Manifest volume = pyramid(glm::dvec3(1));
  View view = viewAt(volume, Projection::kPerspective, 1.5);
  for (const double depth : {1e6, 1e8, 1e10}) {
    view.view_from_world[3].z = depth - 511.5;
    view.focal_px = 1.5 * depth;
    double covered = depth - 512;
    for (const SlabZone& zone : slabZones({&volume, 1e-3}, view, {})) {
      if (zone.near <= covered) covered = std::max(covered, zone.far);
      EXPECT_LE(thicknessPx(zone, view), 1.01) << depth;
      EXPECT_LE(zone.slabs, kMostRaySlabs);
    }
    EXPECT_GE(covered, depth + 512) << depth;
  }
}

// Slabs have the requested thickness, but at least half a pixel; by default at most a pixel or a quarter of a voxel.
TEST(SlabGrid, SlabsAreAsThickAsIsAskedFor) {
  const Manifest volume = pyramid(glm::dvec3(1));
  const auto thickness = [&](double px, double distance) {
    const View view = viewAt(volume, Projection::kOrthographic, px);
    return thicknessPx(slabZones({&volume, 1e-3, distance}, view, {}).front(), view);
  };
  for (const double px : {0.9, 1.27, 1.9, 2.6, 3.7, 6.0}) {
    for (const double distance : {0.25, 0.4, 0.5, 0.6, 2.0 / 3, 0.8, 1.0}) {
      const double most = std::max(1.0, px / 4) * distance / kSampleDistance;
      EXPECT_DOUBLE_EQ(thickness(px, distance), std::max(0.5, std::min(px * distance, most))) << px << ", " << distance;
    }
  }
}

// The largest number of samples a pixel uses a level finer, up to a limit of voxels, and thinner slabs.
TEST(SlabGrid, TheSmallestSubPixelsHaveAFinerLevel) {
  const Manifest volume = pyramid(glm::dvec3(1));  // levels of 2^30, 2^27, 2^24 voxels
  const auto zone = [&](double px, bool finest) {
    const View view = viewAt(volume, Projection::kOrthographic, px);
    return slabZones({&volume, 1e-3, kSampleDistance, false, finest}, view, {}).front();
  };
  const auto expectZone = [&](double px, int level, double thickness_px) {
    EXPECT_EQ(zone(px, true).level, level) << px;
    EXPECT_DOUBLE_EQ(zone(px, true).thickness * px, thickness_px) << px;
  };
  for (const auto& [px, level] : {std::pair{0.3, 1}, {0.2, 2}, {0.1, 3}}) EXPECT_EQ(zone(px, false).level, level);
  expectZone(0.3, 1, 0.3);
  expectZone(0.2, 1, 0.25);
  expectZone(0.1, 2, 0.25);
  expectZone(0.9, 0, 0.45);
}

// In a parallel view, slabs are counted from the view's origin: no part of the volume shifts the slabs.
TEST(SlabGrid, SlabsOfAParallelViewAreCountedFromItsOrigin) {
  const Manifest volume = pyramid(glm::dvec3(1));
  Manifest part = volume;
  part.levels.front().geometry.dims = {300, 200, 100};
  part.levels.front().geometry.world_from_index[3] = glm::dvec4(111, 222, 333.3, 1);
  const View view = viewAt(volume, Projection::kOrthographic, 1.7);
  const auto expectCounted = [&](const Manifest& drawn) {
    const SlabZone zone = slabZones({&drawn, 1e-3}, view, 0).front();
    EXPECT_NEAR(std::remainder(zone.near / zone.thickness, 1.0), 0, 1e-9);
  };
  expectCounted(volume);
  expectCounted(part);
}

// Half a pixel a voxel in the middle, and less behind the middle: still a single level.
TEST(SlabGrid, HalfAPixelAVoxelIsOfOneLevel) {
  const Manifest volume = pyramid(glm::dvec3(1));
  const View view = viewAt(volume, Projection::kPerspective, 0.5);
  const double middle = 3.0 * 1024;
  int behind_the_middle = 0;
  for (const SlabZone& zone : slabZones({&volume, 1e-3}, view, {})) {
    if (zone.near < middle + 0.4 * 1024) {
      EXPECT_EQ(zone.level, 0) << zone.near;
    }
    behind_the_middle += zone.near > middle && zone.level == 0 ? 1 : 0;
  }
  EXPECT_GE(behind_the_middle, 1);
}

// Slabs shared by several volumes are as thick as the thinnest.
TEST(SlabGrid, ACoarseVolumeDoesNotWidenTheSlabsOfAFineOne) {
  const Manifest fine = pyramid(glm::dvec3(1)), coarse = pyramid(glm::dvec3(3));
  const View view = viewAt(fine, Projection::kOrthographic, 1);
  const auto thickness = [&](const Manifest& one, const Manifest& other) {
    const ZonedVolume both[] = {{&one, 1e-3}, {&other, 1e-3}};
    return sharedZones(both, view, {}).front().front().thickness;
  };
  EXPECT_DOUBLE_EQ(thickness(fine, coarse), thickness(fine, fine));
  EXPECT_GT(thickness(coarse, coarse), thickness(fine, fine));
}

}  // namespace
}  // namespace kiln::test
