// Depth of field. Known: points shift by offset · focal length · (1/focus - 1/depth) pixels.
// A picture is the mean of the pictures from the points of the lens.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/error.h"
#include "image/compare.h"
#include "scene/camera/lens.h"
#include "support/reference/drawing.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

Camera frontal() { return {.eye = {15.5, -60, 15.5}, .target = {15.5, 15.5, 15.5}, .up = {0, 0, 1}, .fov_deg = 30}; }

Lens lensOf(double aperture, std::optional<double> focus = {}, int eyes = 12) { return {aperture, focus, eyes}; }

class LensFrames : public ::testing::Test {
 protected:
  // Two balls beside each other: the left at a depth of 66.5, the right at 84.5.
  LensFrames() {
    const DenseVolume near = ball({{32, 32, 32}, VoxelType::f32}, {9, 6.5, 15.5}, 4, 100);
    const DenseVolume far = ball({{32, 32, 32}, VoxelType::f32}, {22, 24.5, 15.5}, 4, 100);
    const DenseVolume volume = fill({{32, 32, 32}, VoxelType::f32}, [&](auto i, auto j, auto k) {
      return std::max(near.valueAt(i, j, k), far.valueAt(i, j, k));
    });
    store_ = makeStore(volume, "lens_balls", 16);
    request_.view = resolve(frontal(), {96, 96});
    request_.transfer_function.unit = 1;
    request_.transfer_function.points = {{40, {1, 0.8, 0.6}, 0.0}, {60, {1, 0.8, 0.6}, 0.9}};
    request_.shading.phong = false;
  }
  Image drawThrough(const Lens& lens) const {
    FrameRequest request = request_;
    request.eyes = viewsThrough(lens, request.view, frontal());
    return draw(store_, request);
  }
  // The greatest difference of alpha between neighbours of the middle row from x0 to x1.
  static double steepest(const Image& image, int x0, int x1) {
    double out = 0;
    for (int x = x0; x < x1; ++x)
      out = std::max(out, std::abs(static_cast<double>(image.pixel(x, 48)[3]) - image.pixel(x + 1, 48)[3]));
    return out;
  }

  std::filesystem::path store_;
  FrameRequest request_;
};

TEST(LensViews, PointsMoveByTheCircleOfConfusion) {
  const View view = resolve(frontal(), {320, 200});
  const glm::dvec2 offset(1.5, -0.7);
  const View moved = fromMovedEye(view, offset, 70);
  for (const double depth : {40.0, 70.0, 200.0}) {
    for (const glm::dvec2& side : {glm::dvec2(0), glm::dvec2(8, -3)}) {
      const glm::dvec3 point = glm::dvec3(side, depth);
      const glm::dvec2 from_middle = view.pixelOf(point), from_eye = moved.pixelOf(point - glm::dvec3(offset, 0));
      const glm::dvec2 shift = offset * view.focal_px * (1 / 70.0 - 1 / depth);
      EXPECT_LT(glm::distance(from_eye, from_middle + shift), 1e-9) << depth;
    }
  }
  // The moved view sees the world from the moved eye.
  const glm::dvec4 world = glm::inverse(view.view_from_world) * glm::dvec4(3, 4, 50, 1);
  EXPECT_LT(glm::distance(moved.view_from_world * world, glm::dvec4(3 - offset.x, 4 - offset.y, 50, 1)), 1e-9);
}

TEST(LensViews, FillTheDiscEvenly) {
  const View view = resolve(frontal(), {100, 100});
  const std::vector<View> eyes = viewsThrough(lensOf(6, 50, 200), view, frontal());
  ASSERT_EQ(eyes.size(), 200u);
  glm::dvec3 mean(0);
  double squares = 0, most = 0;
  for (const View& eye : eyes) {
    const glm::dvec3 offset = eye.eye_world - view.eye_world;
    mean += offset / 200.0;
    squares += glm::dot(offset, offset) / 200;
    most = std::max(most, glm::length(offset));
  }
  EXPECT_LT(glm::length(mean), 0.03);
  EXPECT_NEAR(squares, 3 * 3 / 2.0, 0.01) << "the mean square of a disc's radius is R²/2";
  EXPECT_LE(most, 3);
  EXPECT_TRUE(viewsThrough(lensOf(0), view, frontal()).empty());
  Camera parallel = frontal();
  parallel.projection = Projection::kOrthographic;
  parallel.height = 40;
  EXPECT_THROW(viewsThrough(lensOf(1), resolve(parallel, {100, 100}), parallel), Error);
}

TEST_F(LensFrames, Picture_isTheMeanOfItsViews) {
  const Lens lens = lensOf(5, 66.5);
  const Image image = drawThrough(lens);
  Image mean(96, 96);
  for (const View& eye : viewsThrough(lens, request_.view, frontal())) {
    FrameRequest request = request_;
    request.view = eye;
    const Image one = draw(store_, request);
    for (std::size_t i = 0; i < mean.rgba.size(); ++i) mean.rgba[i] += one.rgba[i] / 12;
  }
  EXPECT_LT(compareImages(image, mean).largest, 1e-6);
}

TEST_F(LensFrames, FocusIsSharp_andOtherDepthsAreNot) {
  const Image sharp = draw(store_, request_);
  const Image near = drawThrough(lensOf(8, 66.5, 64)), far = drawThrough(lensOf(8, 84.5, 64));
  // The balls are in the left and in the right half of the picture.
  const double left = steepest(sharp, 10, 46), right = steepest(sharp, 50, 90);
  EXPECT_GT(steepest(near, 10, 46), 0.7 * left);
  EXPECT_LT(steepest(near, 50, 90), 0.4 * right);
  EXPECT_GT(steepest(far, 50, 90), 0.7 * right);
  EXPECT_LT(steepest(far, 10, 46), 0.4 * left);
}

TEST_F(LensFrames, TinyAperture_changesNothing) {
  EXPECT_LT(compareImages(drawThrough(lensOf(1e-9)), draw(store_, request_)).largest, 1e-5);
}

TEST_F(LensFrames, CropsTilesThreadsAndMemory_changeNoBit) {
  FrameRequest request = request_;
  request.eyes = viewsThrough(lensOf(4, 70, 5), request.view, frontal());
  request.samples = 4;
  const Image whole = draw(store_, request);
  request.tile_px = 128;
  request.band_px = 64;
  EXPECT_TRUE(equalBits(whole, draw(store_, request, 1 << 20)));
  request.crop = PixelRect{20, 30, 70, 60};
  EXPECT_TRUE(equalBits(partOf(whole, *request.crop), draw(store_, request)));
}

}  // namespace
}  // namespace kiln::test
