// The lattice that a zone of depth has: samples between 7/16 of a pixel and a pixel apart wherever the pyramid has a
// level for it, zones that follow each other without a gap, and levels that do not fall on the way.
#include "splat/slab_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "grid/pyramid.h"
#include "splat/sheet.h"

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

// Of a zone's samples, along the axes where they are nearest to each other and farthest apart. unit: pixels, where they
// are seen largest.
struct Apart {
  double least = INFINITY, most = 0;
  double finest = 1;  // what `most` may be: from 16 pixels an edge on, a voxel is refined no further
  Apart(const SlabZone& zone, const Manifest& volume, const View& view) {
    const glm::dvec3 edges = volume.levels[static_cast<std::size_t>(zone.level)].geometry.spacing();
    const double scale = view.focal_px / (view.projection == Projection::kPerspective ? zone.near : 1);
    for (int a = 0; a < 3; ++a) {
      const double px = scale * edges[a] / zone.refinement[static_cast<std::size_t>(a)].ofVoxel();
      least = std::min(least, px), most = std::max(most, px);
      finest = std::max(finest, scale * edges[a] / kLargestRefinement);
    }
  }
};

TEST(SlabGrid, SamplesAreBetweenSevenSixteenthsOfAPixelAndAPixelApart) {
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
          const Apart apart(zone, volume, view);
          EXPECT_GE(apart.least, 0.4375 - 1e-9);
          EXPECT_LE(apart.most, apart.finest + 1e-9);
          EXPECT_GE(zone.level, level);
          EXPECT_DOUBLE_EQ(zone.near, near);
          EXPECT_NEAR(zone.far, zone.near + zone.slabs * zone.thickness, 1e-9 * zone.far);
          level = zone.level, near = zone.far;
        }
      }
    }
  }
}

// Soft blocks' samples tile the others': a block has a whole number of either.
TEST(SlabGrid, SoftBlocksHaveFewerSamples) {
  int judged = 0, free = 0;
  for (const glm::dvec3& voxel : {glm::dvec3(1), glm::dvec3(0.7, 0.7, 0.9), glm::dvec3(0.5, 0.5, 2)}) {
    const Manifest volume = pyramid(voxel);
    for (double px = 0.3; px < 8; px *= 1.03) {
      SCOPED_TRACE(testing::Message() << px << " pixels a voxel of " << voxel.z);
      const View view = viewAt(volume, Projection::kOrthographic, px);
      const auto zone = [&](SoftSamples soft) { return slabZones({&volume, 1e-3, INFINITY, soft}, view, {}).front(); };
      const SlabZone never = zone(SoftSamples::kNever), anyway = zone(SoftSamples::kAnyway);
      EXPECT_FALSE(never.judgesBlocks());
      const SlabZone where_free = zone(SoftSamples::kWhereFree);
      EXPECT_EQ(where_free.refinement, never.refinement);
      free += where_free.judgesBlocks() ? 1 : 0;
      if (!anyway.judgesBlocks()) continue;
      ++judged;
      double part = 1;
      for (std::size_t a = 0; a < 3; ++a) {
        const Refinement &own = anyway.refinement[a], &soft = anyway.soft_refinement[a];
        const int block = softBlock(own);
        EXPECT_EQ(own.samples * block % kRefinedVoxels, 0);
        EXPECT_EQ(soft.samples * block % kRefinedVoxels, 0);
        EXPECT_LE(block, kMostSoftBlock);
        EXPECT_TRUE(unitHasRoom(own, block));
        EXPECT_GE(own.samples, never.refinement[a].samples);
        EXPECT_LE(own.samples, 1.25 * never.refinement[a].samples);
        EXPECT_LE(view.focal_px * voxel[static_cast<int>(a)] / soft.ofVoxel(), 1 + 1e-9);
        part *= soft.ofVoxel() / never.refinement[a].ofVoxel();
      }
      EXPECT_LE(part, 0.6);
      EXPECT_EQ(FootprintTable(anyway.sigma_px, anyway.soft_sigma_px).taps(), FootprintTable(anyway.sigma_px).taps());
    }
  }
  EXPECT_GT(judged, 100);
  EXPECT_GT(free, 30);
  EXPECT_LT(free, judged);
}

// Between samples of what is not steep is nearly their mean: fewer do, down to one and three eighths a voxel.
TEST(SlabGrid, SamplesOfSoftFunctionsAreFewer) {
  const Manifest volume = pyramid(glm::dvec3(1));
  for (const double px : {0.5, 1.0, 1.27, 2.0, 6.0}) {
    const View view = viewAt(volume, Projection::kOrthographic, px);
    const auto apart = [&](double steepness) {
      return Apart(slabZones({&volume, 1e-3, steepness}, view, {}).front(), volume, view).most;
    };
    EXPECT_DOUBLE_EQ(apart(1.001), apart(INFINITY));
    EXPECT_GE(apart(1), apart(INFINITY));
    if (px > 0.7) {
      EXPECT_NEAR(apart(1), std::min(1.0, px * 8 / 11), 0.05) << px;
    }
  }
}

// As far apart as is asked for, but half a pixel and no more than a pixel, by default three quarters.
TEST(SlabGrid, SamplesAreAsFarApartAsIsAskedFor) {
  const Manifest volume = pyramid(glm::dvec3(1));
  const auto apart = [&](double px, double distance) {
    const View view = viewAt(volume, Projection::kOrthographic, px);
    return Apart(slabZones({&volume, 1e-3, INFINITY, SoftSamples::kNever, distance}, view, {}).front(), volume, view);
  };
  for (const double px : {0.9, 1.27, 1.9, 2.6, 3.7, 6.0}) {
    double before = 0;
    for (const double distance : {0.25, 0.4, 0.5, 0.6, 2.0 / 3, 0.8, 1.0}) {
      const Apart found = apart(px, distance);
      EXPECT_GE(found.least, 0.4375 - 1e-9);
      EXPECT_LE(found.most, 1 + 1e-9);
      EXPECT_GE(found.most, before) << px << " pixels, " << distance;
      if (px * distance < 0.58) {
        EXPECT_NEAR(found.most, std::max(0.5, px * distance), 0.07);
      }
      before = found.most;
    }
    EXPECT_LE(apart(px, 0.5).most, std::max(0.75, px * 0.1875) + 1e-9);
  }
  EXPECT_NEAR(apart(1, 1).most, 1, 1e-9);
  EXPECT_NEAR(apart(2, 0.25).most, 0.5, 0.05);
}

// Half a pixel a voxel in the middle, and less behind it: one level all the same.
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

// Slabs that they share are as thick as the widest spacing, which is that of solids where one of them is steep.
TEST(SlabGrid, ASoftVolumeDoesNotWidenTheSlabsOfASteepOne) {
  const Manifest volume = pyramid(glm::dvec3(1));
  const View view = viewAt(volume, Projection::kOrthographic, 1);
  const auto thickness = [&](double one, double other) {
    const ZonedVolume both[] = {{&volume, 1e-3, one}, {&volume, 1e-3, other}};
    return sharedZones(both, view, {}).front().front().thickness;
  };
  EXPECT_DOUBLE_EQ(thickness(0.1, 30), thickness(30, 30));
  EXPECT_GT(thickness(0.1, 0.1), thickness(30, 30));
}

// A voxel of a coarser level hides as much more.
TEST(SlabGrid, ACoarserLevelIsSteeper) {
  const Manifest volume = pyramid(glm::dvec3(1));
  const auto apart = [&](int level, double steepness) {
    const View view = viewAt(volume, Projection::kOrthographic, 2 / std::exp2(level));
    return Apart(slabZones({&volume, 1e-3, steepness}, view, level).front(), volume, view).most;
  };
  EXPECT_GT(apart(0, 0.5), apart(0, 2));
  EXPECT_DOUBLE_EQ(apart(1, 0.5), apart(0, 0.5));
  EXPECT_DOUBLE_EQ(apart(2, 0.5), apart(0, 2));
}

}  // namespace
}  // namespace kiln::test
