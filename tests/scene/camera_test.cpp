// Known answers: a camera on the -y axis, looking along +y with +z up, has view axes parallel to the world's, so every
// projection can be computed by hand.
#include "scene/camera/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "base/error.h"
#include "support/system/expect_error.h"

namespace kiln {
namespace {

Camera frontCamera() {
  Camera camera;
  camera.eye = {0, -10, 0};
  camera.target = {0, 0, 0};
  camera.up = {0, 0, 1};
  camera.fov_deg = 90;
  return camera;
}

glm::dvec2 pixelOfWorld(const View& view, const glm::dvec3& world) {
  return view.pixelOf(glm::dvec3(view.view_from_world * glm::dvec4(world, 1)));
}

void expectRefused(const Camera& camera, const ImageSize& size, const std::string& word) {
  test::expectError([&] { resolve(camera, size); }, ErrorCode::kUsage, word);
}

TEST(Camera, ViewAxesAreRightDownForward) {
  const View view = resolve(frontCamera(), {200, 100});
  const auto inView = [&](glm::dvec3 p) { return glm::dvec3(view.view_from_world * glm::dvec4(p, 1)); };
  EXPECT_LT(glm::distance(inView({0, 0, 0}), {0, 0, 10}), 1e-12);
  EXPECT_LT(glm::distance(inView({3, 0, 0}), {3, 0, 10}), 1e-12);
  EXPECT_LT(glm::distance(inView({0, 0, 3}), {0, -3, 10}), 1e-12);
  EXPECT_LT(glm::distance(view.forward_world, {0, 1, 0}), 1e-12);
}

// tan(45°) = 1: at a distance equal to half the height, half the height is visible. A point 10 up at depth 10 is on the
// upper edge.
TEST(Camera, PerspectiveEdgeOfTheFieldOfView) {
  const View view = resolve(frontCamera(), {200, 100});
  EXPECT_NEAR(view.focal_px, 50, 1e-12);
  EXPECT_NEAR(pixelOfWorld(view, {0, 0, 10}).y, 0, 1e-9);
  EXPECT_NEAR(pixelOfWorld(view, {0, 0, -10}).y, 100, 1e-9);
  EXPECT_NEAR(pixelOfWorld(view, {20, 0, 0}).x, 200, 1e-9);
  EXPECT_NEAR(pixelOfWorld(view, {0, 90, 50}).y, 25, 1e-9);  // depth 100, so half an edge for 50
}

TEST(Camera, OrthographicHeightSpansTheImage) {
  Camera camera = frontCamera();
  camera.projection = Projection::kOrthographic;
  camera.height = 8;
  const View view = resolve(camera, {200, 100});
  EXPECT_NEAR(view.focal_px, 12.5, 1e-12);
  EXPECT_NEAR(pixelOfWorld(view, {0, 7, 4}).y, 0, 1e-9);
  EXPECT_NEAR(pixelOfWorld(view, {-8, -3, 0}).x, 0, 1e-9);
}

// Known because parallel rays do not depend on their starting points. The pixel and the view-space position of a point
// near the volume must not depend on the eye's distance. Its depth from the eye is its view-space depth plus the
// origin's.
TEST(Camera, ParallelViewNearAVolume_dependsOnNoDistance) {
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.height = 80;
  camera.target = {31.5, 31.5, 31.5};
  camera.up = {0, 0, 1};
  const glm::dvec3 point(20, 45, 10);
  camera.eye = {31.5, -168.5, 31.5};
  const View near = nearVolume(resolve(camera, {128, 128}), {30, 30, 30}, 50);
  for (const double distance : {1e3, 1e7, 1e12, 1e18}) {
    camera.eye.y = -distance;
    const View view = nearVolume(resolve(camera, {128, 128}), {30, 30, 30}, 50);
    EXPECT_EQ(view.view_from_world, near.view_from_world) << distance;
    const double depth = (view.view_from_world * glm::dvec4(point, 1)).z + view.origin_depth;
    EXPECT_NEAR(depth, point.y + distance, 1e-12 * distance) << distance;
  }
  // The target may also be far away, on the same ray.
  camera.target.y = camera.eye.y + 1e3;
  EXPECT_EQ(nearVolume(resolve(camera, {128, 128}), {30, 30, 30}, 50).view_from_world, near.view_from_world);
  const View unmoved = resolve(camera, {128, 128});
  EXPECT_EQ(unmoved.origin_depth, 0);
  camera.projection = Projection::kPerspective;
  EXPECT_EQ(nearVolume(resolve(camera, {128, 128}), {30, 30, 30}, 50).view_from_world,
            resolve(camera, {128, 128}).view_from_world);
}

TEST(Camera, ViewIsARigidMotionForAnyCamera) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-100, 100);
  for (int n = 0; n < 200; ++n) {
    Camera camera;
    camera.eye = {uniform(random), uniform(random), uniform(random)};
    camera.target = {uniform(random), uniform(random), uniform(random)};
    camera.up = {uniform(random), uniform(random), uniform(random)};
    const View view = resolve(camera, {64, 64});
    const glm::dmat3 r(view.view_from_world);
    EXPECT_NEAR(glm::determinant(r), 1, 1e-12);
    EXPECT_LT(glm::distance(r * (camera.target - camera.eye), {0, 0, glm::distance(camera.target, camera.eye)}), 1e-9);
    EXPECT_LT((r * camera.up).y, 0);  // up is towards smaller rows
  }
}

// The two EXR matrices describe the camera of pixelOf, in other axes.
TEST(Camera, ExrMatricesAgreeWithPixels) {
  Camera camera = frontCamera();
  camera.eye = {3, -20, 5};
  camera.height = 30;
  const glm::dvec3 world(1, 2, -3);
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    camera.projection = projection;
    const View view = resolve(camera, {320, 200});
    const glm::dvec4 ndc = exrWorldToNdc(view) * glm::dvec4(world, 1);
    const glm::dvec2 pixel = pixelOfWorld(view, world);
    EXPECT_NEAR(ndc.x / ndc.w, pixel.x / 320, 1e-12);
    EXPECT_NEAR(ndc.y / ndc.w, pixel.y / 200, 1e-12);
    EXPECT_GT(std::abs(glm::determinant(exrWorldToNdc(view))), 0);
    const glm::dvec4 seen = exrWorldToCamera(view) * glm::dvec4(world, 1);
    const glm::dvec4 ours = view.view_from_world * glm::dvec4(world, 1);
    EXPECT_LT(glm::distance(glm::dvec3(seen), glm::dvec3(ours.x, -ours.y, -ours.z)), 1e-12);
  }
}

TEST(Camera, RefusesWhatHasNoPicture) {
  const ImageSize size{64, 64};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Camera camera = frontCamera();
  camera.target = camera.eye;
  expectRefused(camera, size, "same point");
  camera = frontCamera();
  camera.up = {0, -2, 0};
  expectRefused(camera, size, "up runs along");
  camera.up = {0, 0, 0};
  expectRefused(camera, size, "zero");
  for (const double fov : {0.0, -1.0, 180.0, nan, 1e-320}) {
    camera = frontCamera();
    camera.fov_deg = fov;
    expectRefused(camera, size, "field of view");
  }
  camera = frontCamera();
  camera.projection = Projection::kOrthographic;
  for (const double height : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    camera.height = height;
    expectRefused(camera, size, "height");
  }
  camera = frontCamera();
  camera.eye.x = nan;
  expectRefused(camera, size, "finite");
  camera.eye.x = 1e300;
  expectRefused(camera, size, "too");
  for (const ImageSize bad : {ImageSize{0, 5}, ImageSize{5, -1}, ImageSize{65537, 1}}) {
    expectRefused(frontCamera(), bad, "pixels");
  }
}

}  // namespace
}  // namespace kiln
