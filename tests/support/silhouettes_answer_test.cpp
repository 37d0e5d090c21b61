// The measure of edges: positions of silhouettes, pixels near them, and the difference of two pictures there. Known
// because the pictures are made for the test, and from the closed form of a uniform medium.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/reference/silhouettes.h"

namespace kiln::test {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

TEST(Silhouettes, ReachTwoPixelsToEitherSide) {
  Image picture(12, 9);
  std::vector<double> depth(12 * 9, kNothing);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (i % 12 < 6) continue;
    picture.rgba[4 * i + 3] = 1;
    depth[i] = i / 12 < 5 ? 20 : 30;
  }
  const std::vector<bool> one = silhouetteBand(picture, depth, 12), two = silhouetteBand(picture, depth, 8);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const std::size_t x = i % 12, y = i / 12;
    const bool beside = x >= 4 && x < 8, around = x >= 5 && y >= 3 && y < 7;
    EXPECT_EQ(one[i], beside) << x << ", " << y;
    EXPECT_EQ(two[i], beside || around) << x << ", " << y;
  }
  // A difference of a tenth in all channels of the band is 20 dB; pixels outside the band have no influence.
  Image other = picture;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) other.rgba[4 * i + c] += one[i] ? 0.1f : 0.7f;
  }
  EXPECT_NEAR(psnrWithin(one, picture, other), 20, 1e-5);
  EXPECT_EQ(psnrWithin(one, picture, picture), kNothing);
}

TEST(Silhouettes, FirstHitsAreWhereHalfOfTheLightIsLeft) {
  constexpr double kTau = 0.25;
  const DenseVolume volume = fill({{20, 20, 20}, VoxelType::u8}, [](auto, auto, auto) { return 100; });
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.eye = {9.5, 9.5, -30}, camera.target = {9.5, 9.5, 9.5}, camera.up = {0, 1, 0};
  camera.height = 40;
  TransferFunction function;
  function.unit = 1;
  function.points = {{0, {1, 1, 1}, -std::expm1(-kTau)}};
  const std::vector<double> hits = firstHits(volume, resolve(camera, {4, 4}), function, {4, 0.1, 1});
  for (std::size_t i = 0; i < hits.size(); ++i) {
    // Pixels of ten voxels; the volume fills the middle four. Rays begin at the eye.
    const bool meets = i / 4 % 3 != 0 && i % 4 % 3 != 0;
    if (meets)
      EXPECT_NEAR(hits[i], 29.5 + std::numbers::ln2 / kTau, 0.1) << i;
    else
      EXPECT_EQ(hits[i], kNothing) << i;
  }
}

}  // namespace
}  // namespace kiln::test
