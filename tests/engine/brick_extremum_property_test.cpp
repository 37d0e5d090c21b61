// Greatest values along rays through several bricks: each point of a ray belongs to one brick.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/shared/brick_extremum.h"
#include "store/store_reader.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// A volume that is bright in a plane of voxels, as bricks of 8³ along x. Rays cross the bright plane where they cross
// the face between two bricks, so that rounding decides which brick holds the peak.
TEST(BrickExtremum, APeakOnAFaceBetweenBricksIsInOneOfThem) {
  const DenseVolume volume = fill({{16, 8, 8}, VoxelType::f32}, [](auto, auto j, auto) { return j == 4 ? 1.0 : 0.0; });
  const StoreReader store(makeStore(volume, "bright_plane", 8));
  const BrickBlock left = store.read({0, {0, 0, 0}}), right = store.read({0, {1, 0, 0}});
  int lost = 0;
  constexpr int kRays = 20000;
  for (std::uint64_t i = 0; i < kRays; ++i) {
    const auto between = [&](double lo, double hi, std::uint64_t what) { return lo + (hi - lo) * hashUnit(what, i); };
    const glm::dvec3 peak(7.5, 4, between(2, 5, 1));
    IndexRay ray;
    ray.slope = {between(0.2, 1, 2), between(0.2, 1, 3), between(-0.2, 0.2, 4)};
    ray.base = peak - between(3, 40, 5) * ray.slope;
    // As a frame divides a ray among its bricks.
    constexpr double kFar = 1000;
    const DepthSpan in_left = ray.within({-0.5, -0.5, -0.5}, {7.5, 7.5, 7.5}, {0, kFar});
    const DepthSpan in_right = ray.within({7.5, -0.5, -0.5}, {15.5, 7.5, 7.5}, {0, kFar});
    DrawCounts counts;
    double held = -1;
    BrickExtremum<float, false>(left, false, counts).take(ray, {in_left, true, false}, held);
    BrickExtremum<float, false>(right, false, counts).take(ray, {in_right, false, true}, held);
    if (held < 1 - 1e-6) ++lost;
  }
  EXPECT_EQ(lost, 0) << "of " << kRays;
}

}  // namespace
}  // namespace kiln::test
