// The picture of an eye of a stereo pair. Known: a point at depth z is f b (1/z - 1/c) pixels farther to the right for
// the left eye than for the right eye, at equal height. The picture is a part of the wider picture of a camera in the
// eye's place that looks straight ahead. The axis is not in the picture's middle, so corners are farther from the axis;
// pictures stay equal for all brick sizes.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "base/error.h"
#include "image/compare.h"
#include "job/stereo.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kStereoSize{80, 60};

TEST(Stereo, PointsAreShiftedByTheirDepth) {
  Camera camera;
  camera.eye = {1, 2, 3};
  camera.target = {4, -2, 15};
  camera.up = {0.2, 1, -0.1};
  const double distance = glm::length(camera.target - camera.eye);
  const View middle = resolve(camera, kStereoSize);
  for (const std::optional<double>& convergence : {std::optional<double>(), std::optional(30.0)}) {
    const View left = resolve(camera, Stereo{StereoEye::kLeft, 0.6, convergence}, kStereoSize);
    const View right = resolve(camera, Stereo{StereoEye::kRight, 0.6, convergence}, kStereoSize);
    EXPECT_NEAR(glm::distance(left.eye_world, right.eye_world), 0.6, 1e-12);
    for (const glm::dvec3& point : {glm::dvec3(4, -2, 15), {2, 0, 9}, {9, -5, 40}}) {
      const auto seen = [&](const View& view) {
        return view.pixelOf(glm::dvec3(view.view_from_world * glm::dvec4(point, 1)));
      };
      const double depth = (middle.view_from_world * glm::dvec4(point, 1)).z;
      const double shift = 0.6 * middle.focal_px * (1 / depth - 1 / convergence.value_or(distance));
      EXPECT_NEAR(seen(left).x - seen(right).x, shift, 1e-9);
      EXPECT_NEAR(seen(left).x + seen(right).x, 2 * seen(middle).x, 1e-9);
      EXPECT_NEAR(seen(left).y, seen(middle).y, 1e-9);
      EXPECT_NEAR(seen(right).y, seen(middle).y, 1e-9);
    }
  }
  camera.projection = Projection::kOrthographic;
  EXPECT_THROW(resolve(camera, Stereo{StereoEye::kLeft, 0.6, {}}, kStereoSize), Error);
  EXPECT_EQ(resolve(camera, std::nullopt, kStereoSize).eye_world, camera.eye);
}

TEST(Stereo, IsAPartOfAWiderPictureFromTheEye) {
  const DenseVolume volume = head({{40, 51, 37}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8));
  const auto small = makeStore(volume, "small", 16), large = makeStore(volume, "large", 64);
  for (std::uint64_t seed = 40; seed < casesOf(44u, 42u); ++seed) {
    RandomScene scene = randomScene(seed, volume, kStereoSize);
    scene.camera = cameraFrom(volume.geometry, randomDirection(seed, 1), Projection::kPerspective);
    scene.camera.eye = glm::mix(scene.camera.target, scene.camera.eye, 0.45);
    scene.camera.fov_deg = 50;
    // The interocular distance gives a shift of 24 pixels.
    Stereo stereo{seed % 2 == 0 ? StereoEye::kLeft : StereoEye::kRight, 0, 100};
    stereo.interocular = 2 * 24 * 100 / resolve(scene.camera, kStereoSize).focal_px;
    scene.view = resolve(scene.camera, stereo, kStereoSize);
    FrameRequest request = requestOf(scene, Lattice::kPixel, 0.998);
    request.level = 0;
    const Image eye = draw(large, request);
    EXPECT_TRUE(equalBits(eye, draw(small, request))) << "seed " << seed;

    View wide = scene.view;
    wide.size.width += 48;
    wide.centre_px = 0.5 * glm::dvec2(wide.size.width, wide.size.height);
    request.view = wide;
    const int first = stereo.eye == StereoEye::kLeft ? 48 : 0;
    request.crop = PixelRect{first, 0, first + kStereoSize.width, kStereoSize.height};
    const ImageDifference difference = compareImages(eye, draw(large, request));
    EXPECT_GT(difference.psnr_db, 60) << "seed " << seed;
    EXPECT_GT(difference.foreground, 500u) << "seed " << seed;
  }
}

}  // namespace
}  // namespace kiln::test
