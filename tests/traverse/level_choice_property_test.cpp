// Properties of `--level auto`: the bricks of a frame fill the volume without overlap. No brick has voxels larger than
// a pixel while finer ones exist, and no brick could have been coarser.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "grid/pyramid.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"
#include "traverse/brick_walk.h"

namespace kiln::test {
namespace {

constexpr std::int64_t kBrick = 8;

// Returns the pixels covered by a length across the view at the nearest corner of a box of voxels.
double pixelsOf(double length, const VolumeGeometry& geometry, const VoxelBox& box, const View& view) {
  if (view.projection == Projection::kOrthographic) return length * view.focal_px;
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    glm::dvec3 at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<double>((corner >> axis & 1) != 0 ? box.hi[axis] : box.lo[axis]) - 0.5;
    const double depth = (view.view_from_world * glm::dvec4(geometry.worldOf(at), 1)).z;
    if (depth <= 0) return std::numeric_limits<double>::infinity();
    most = std::max(most, length * view.focal_px / depth);
  }
  return most;
}

class LevelChoice : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    const Extent3 dims[] = {{45, 38, 50}, {40, 33, 26}, {30, 57, 41}};
    const glm::dmat4 affines[] = {glm::dmat4(1.0), anisotropicAffine(), obliqueAffine()};
    const VolumeShape shape{dims[GetParam()], VoxelType::u8, affines[GetParam()]};
    store_.emplace(makeStore(noise(shape, 5, {100, 200}), "noise", kBrick));
  }

  const VolumeGeometry& geometry(int level) const { return store_->level(level).geometry; }
  // Level-0 voxels along each axis of a voxel of `level`.
  Extent3 span(int level) const {
    Extent3 out{1, 1, 1};
    for (int l = 0; l < level; ++l) {
      const Extent3 by = halvingOf(geometry(l));
      out = {out.x * by.x, out.y * by.y, out.z * by.z};
    }
    return out;
  }
  // Returns the largest voxel edge along the axes that were halved to reach this level.
  double halvedEdge(int level) const {
    double out = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (span(level)[axis] > 1) out = std::max(out, geometry(level).spacing()[axis]);
    }
    return out;
  }
  VoxelBox coarseBoxOf(const BrickKey& key) const {
    const Extent3 own = span(key.level), next = span(key.level + 1);
    const BrickCoord parent{static_cast<std::int32_t>(key.brick.x / (next.x / own.x)),
                            static_cast<std::int32_t>(key.brick.y / (next.y / own.y)),
                            static_cast<std::int32_t>(key.brick.z / (next.z / own.z))};
    return coreBox(parent, kBrick, geometry(key.level + 1).dims);
  }

  void check(const View& view, std::uint64_t seed) {
    const FrameLevels levels(store_->manifest(), std::nullopt, view, ProjectedArea::kBox);
    const PixelRect anywhere{-1'000'000'000, -1'000'000'000, 1'000'000'000, 1'000'000'000};
    const auto always = [&](int, const VoxelBox&, const BrickEntry&, const RectTest& test) { return test(anywhere); };
    const BrickWalk walk(*store_, levels, {voxelLevelChoice(levels), always});
    BrickWalkCounts counts;
    const std::vector<BrickInView> bricks = walk.inView(anywhere, counts);
    std::vector<int> covered(static_cast<std::size_t>(geometry(0).dims.count()));
    for (const BrickInView& in_view : bricks) {
      const BrickKey& key = in_view.key;
      const VoxelBox box = coreBox(key.brick, kBrick, geometry(key.level).dims);
      if (key.level > 0) {
        EXPECT_LE(pixelsOf(halvedEdge(key.level), geometry(key.level), box, view), 1 + 1e-9) << "seed " << seed;
      }
      if (key.level + 1 < store_->index().levels()) {
        const double coarser = pixelsOf(halvedEdge(key.level + 1), geometry(key.level + 1), coarseBoxOf(key), view);
        EXPECT_GT(coarser, 1 - 1e-9) << "seed " << seed << " level " << key.level;
      }
      cover(key.level, box, covered);
      ++drawn_[static_cast<std::size_t>(key.level)];
    }
    EXPECT_GE(counts.bricks, bricks.size());  // bricks behind the eye are not in view
    // With the whole volume in front of the eye, each voxel lies in exactly one brick.
    if (counts.bricks == bricks.size()) {
      ++complete_;
      for (const int times : covered) ASSERT_EQ(times, 1) << "seed " << seed;
    }
  }

  void cover(int level, const VoxelBox& box, std::vector<int>& covered) const {
    const Extent3 by = span(level);
    const Extent3& n = geometry(0).dims;
    const VoxelBox fine = intersection(
        {{box.lo.x * by.x, box.lo.y * by.y, box.lo.z * by.z}, {box.hi.x * by.x, box.hi.y * by.y, box.hi.z * by.z}},
        boxOf(n));
    for (std::int64_t z = fine.lo.z; z < fine.hi.z; ++z) {
      for (std::int64_t y = fine.lo.y; y < fine.hi.y; ++y) {
        for (std::int64_t x = fine.lo.x; x < fine.hi.x; ++x)
          ++covered[static_cast<std::size_t>((z * n.y + y) * n.x + x)];
      }
    }
  }

  std::optional<StoreReader> store_;
  std::vector<int> drawn_ = std::vector<int>(64);
  int complete_ = 0;
};

TEST_P(LevelChoice, FillsTheVolumeWithPixelSizedVoxels) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Random random(seed);
    const int pixels = random.between(8, 200);
    check(resolve(randomCamera(random, geometry(0)), {pixels, pixels}), seed);
  }
  EXPECT_GT(complete_, 8);
  // The coarsest level is correct only for views where the whole volume covers a few pixels.
  for (int level = 0; level + 1 < store_->index().levels(); ++level)
    EXPECT_GT(drawn_[static_cast<std::size_t>(level)], 0) << "level " << level;
}

INSTANTIATE_TEST_SUITE_P(Volumes, LevelChoice, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace kiln::test
