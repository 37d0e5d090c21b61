// Lights, clipping, opacity by gradient, background. Known for three reasons:
// 1. A ramp has an equal gradient everywhere, so every sample has the same normal. Colour over alpha is the shading
// formula, in the reference renderer and in the kernels.
// 2. A box of voxels is a smaller volume.
// 3. The clipped part of a ray has a known length.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <vector>

#include "image/compare.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr int kScenePixels = 48;

TransferFunction allOver(double opacity) { return {1, {{0, {0.9, 0.6, 0.3}, opacity}}}; }

class Scenes : public ::testing::TestWithParam<Projection> {
 protected:
  Scenes()
      : volume_(ramp({{24, 20, 16}, VoxelType::u8, obliqueAffine()}, 1, 10)),
        store_(makeStore(volume_, "scene_ramp_" + std::to_string(static_cast<int>(GetParam())), 16)) {
    // Directions far from the gradient and far from perpendicular to it, so that no ray meets the surface edge on.
    const glm::dvec3 from = glm::normalize(worldGradient()) + glm::dvec3(0.1, -0.5, 0.4);
    request_.view = resolve(cameraFrom(volume_.geometry, from, GetParam()), {kScenePixels, kScenePixels});
    request_.level = 0;
    request_.opacity_threshold = 0.9999;
    request_.transfer_function = allOver(0.05);
  }
  Image splatted() const { return draw(store_, request_); }
  Image reference() const {
    return referenceImage(volume_, request_.view, request_.transfer_function, request_.shading, {},
                          {2, 0.25, 1, true, request_.clipping});
  }
  glm::dvec3 worldGradient() const {
    return glm::transpose(glm::inverse(glm::dmat3(volume_.geometry.world_from_index))) * glm::dvec3(10, 0, 0);
  }
  glm::dvec3 centre() const { return volume_.geometry.worldOf({11.5, 9.5, 7.5}); }

  DenseVolume volume_;
  std::filesystem::path store_;
  FrameRequest request_;
};

// Returns the largest difference of colour over alpha among pixels with more alpha; `pixels` is their number.
double colorDifference(const Image& a, const Image& b, int& pixels, float alpha) {
  double largest = 0;
  pixels = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const float *p = a.pixel(x, y), *q = b.pixel(x, y);
      if (!(p[3] > alpha && q[3] > alpha)) continue;
      ++pixels;
      for (int channel = 0; channel < 3; ++channel)
        largest = std::max(largest, std::abs(static_cast<double>(p[channel] / p[3] - q[channel] / q[3])));
    }
  }
  return largest;
}

TEST_P(Scenes, LightsAreThoseOfTheReference) {
  const glm::dvec3 eye_side = -request_.view.forward_world;
  const Light head{LightKind::kHeadlight, {}, {1, 0.8, 0.6}, 0.5};
  const Light sun{LightKind::kDirectional, 3.0 * (eye_side + glm::dvec3(0.8, 0.3, 0.9)), {0.3, 0.5, 1}, 0.9};
  const Light behind{LightKind::kDirectional, -eye_side + glm::dvec3(0.1, 0, 0.2), {5, 5, 5}, 1};
  const Light lamp{LightKind::kPoint, centre() + 40.0 * eye_side + glm::dvec3(15, 9, -20), {1, 0.2, 0.2}, 0.7};
  const std::vector<std::vector<Light>> lights = {
      {}, {Light{}}, {head}, {sun}, {sun, behind}, {lamp}, {head, sun, lamp, head}};
  std::vector<Image> pictures;
  request_.sample_distance = 0.25;
  // A pixel at an edge of the box has rays through faces of different normals; one ray in both pictures.
  request_.filters_rays = false;
  const auto reference = [&] {
    return referenceImage(volume_, request_.view, request_.transfer_function, request_.shading, {},
                          {1, 0.25, 1, true, request_.clipping});
  };
  for (const std::vector<Light>& these : lights) {
    request_.shading = Shading{true, 0.15, 0.7, 0.3, 9, these};
    pictures.push_back(splatted());
    int pixels = 0;
    // A point's light changes within a footprint and along the ray; so does any highlight in perspective.
    // Near the border of the volume, which has normals of its own, samples of a quarter of a voxel are steps.
    EXPECT_LT(colorDifference(pictures.back(), reference(), pixels, 0.4f), 0.035) << pictures.size();
    EXPECT_GT(pixels, 300);
  }
  int pixels = 0;
  EXPECT_GT(colorDifference(pictures[0], pictures[1], pixels, 0.4f), 0.05);
  EXPECT_GT(colorDifference(pictures[2], pictures[6], pixels, 0.4f), 0.05);
}

// Rays are cut exactly, voxels by their centres: the remaining material agrees in the mean.
TEST_P(Scenes, ClippingLeavesWhatTheReferenceLeaves) {
  const Clipping clippings[] = {
      {VoxelBox{{4, 3, 0}, {19, 20, 9}}, {}},
      {std::nullopt, {{{1, -2, 0.5}, 3 - glm::dot(glm::dvec3(1, -2, 0.5), centre())}}},
      {VoxelBox{{0, 0, 2}, {24, 17, 16}}, {{{-0.3, -1, 1}, 4 - glm::dot(glm::dvec3(-0.3, -1, 1), centre())}}}};
  const double whole = compareImages(reference(), splatted()).mean_brightness_ratio;
  for (const Clipping& clipping : clippings) {
    request_.clipping = clipping;
    const ImageDifference d = compareImages(reference(), splatted());
    EXPECT_NEAR(d.mean_brightness_ratio, whole, 0.02);
    EXPECT_GT(d.foreground_psnr_db, 24);
  }
}

// A solid cut perpendicular to a direction: the shading formula with this normal gives the brightness of the face.
TEST_P(Scenes, ACutIsAFaceWithTheNormalOfItsPlane) {
  request_.transfer_function = allOver(1);
  request_.shading = Shading{true, 0.2, 0.8, 0, 1, {Light{}}};
  const glm::dvec3 towards = -request_.view.forward_world;
  const glm::dvec3 across = glm::normalize(glm::cross(towards, glm::dvec3(0, 0, 1)));
  for (const double turned : {0.0, 0.6}) {
    const glm::dvec3 normal = -std::cos(turned) * towards - std::sin(turned) * across;
    request_.clipping = {std::nullopt, {{normal, -glm::dot(normal, centre())}}};
    const double expected = 0.2 + 0.8 * std::cos(turned);
    for (const Image& image : {splatted(), reference()}) {
      const float* middle = image.pixel(kScenePixels / 2, kScenePixels / 2);
      EXPECT_NEAR(middle[3], 1, 1e-3);
      EXPECT_NEAR(middle[0], 0.9 * expected, 0.02);
      EXPECT_NEAR(middle[2], 0.3 * expected, 0.01);
    }
  }
}

// A solid of noise, whose gradients are noise. Known because planes on the border clip nothing and have its normals,
// and because one ray through the middle of the picture enters a face of the box, whose normal is that of the plane.
TEST_P(Scenes, BorderOfTheVolume_isLitAsAFace) {
  const DenseVolume noise = fill({{24, 20, 16}, VoxelType::u8, obliqueAffine()}, [](auto i, auto j, auto k) {
    return static_cast<double>(100 + (i * 7919 + j * 104729 + k * 1299709) % 101);
  });
  const auto store = makeStore(noise, "scene_noise_" + std::to_string(static_cast<int>(GetParam())), 16);
  request_.transfer_function = allOver(1);
  const glm::dmat3 world(noise.geometry.world_from_index);
  std::vector<ClipPlane> planes;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      glm::dvec3 face(11.5, 9.5, 7.5);
      face[axis] = side < 0 ? -0.5 : static_cast<double>(noise.geometry.dims[axis]) - 0.5;
      const glm::dvec3 normal = -side * glm::normalize(glm::column(glm::transpose(glm::inverse(world)), axis));
      planes.push_back({normal, -glm::dot(normal, noise.geometry.worldOf(face))});
    }
  }
  // The face that a ray to the centre enters last.
  double entry = -std::numeric_limits<double>::infinity(), cosine = 0;
  for (const ClipPlane& plane : planes) {
    const double slope = glm::dot(plane.normal, request_.view.forward_world);
    if (!(slope > 0)) continue;
    const double at = -(glm::dot(plane.normal, centre()) + plane.offset) / slope;
    if (at > entry) entry = at, cosine = slope;
  }
  const std::vector<std::vector<Light>> lights = {{Light{}}, {Light{LightKind::kHeadlight, {}, {1, 1, 1.001}, 1}}};
  for (const Lattice lattice : kLattices) {
    for (const std::vector<Light>& these : lights) {
      request_.lattice = lattice;
      request_.shading = Shading{true, 0.2, 0.8, 0, 1, these};
      request_.clipping = {};
      const Image whole = draw(store, request_);
      EXPECT_NEAR(whole.pixel(kScenePixels / 2, kScenePixels / 2)[0], 0.9 * (0.2 + 0.8 * cosine), 0.02);
      request_.clipping = {std::nullopt, planes};
      int pixels = 0;
      // The planes cut the ends of samples at edges of the box; noise would differ by a half.
      EXPECT_LT(colorDifference(whole, draw(store, request_), pixels, 0.999f), lattice == Lattice::kVoxel ? 2e-3 : 0.05)
          << nameOf(lattice);
      EXPECT_GT(pixels, 300);
    }
  }
  request_.clipping = {};
  const Image truth =
      referenceImage(noise, request_.view, request_.transfer_function, request_.shading, {}, {2, 0.25, 1, true, {}});
  EXPECT_NEAR(truth.pixel(kScenePixels / 2, kScenePixels / 2)[0], 0.9 * (0.2 + 0.8 * cosine), 0.02);
}

TEST_P(Scenes, ARegionIsTheSmallerVolume) {
  request_.shading.phong = false;
  request_.clipping.region = VoxelBox{{16, 0, 0}, {24, 16, 16}};
  DenseVolume part{volume_.geometry, volume_.type, {}};
  part.geometry.dims = {8, 16, 16};
  part.geometry.world_from_index[3] = glm::dvec4(volume_.geometry.worldOf({16, 0, 0}), 1);
  part = fill({part.geometry.dims, part.type, part.geometry.world_from_index},
              [&](std::int64_t i, std::int64_t j, std::int64_t k) { return volume_.valueAt(i + 16, j, k); });
  const auto store = makeStore(part, "scene_part_" + std::to_string(static_cast<int>(GetParam())), 16);
  const Clipping clipping = request_.clipping;
  for (const Lattice lattice : kLattices) {
    request_.lattice = lattice;
    request_.clipping = clipping;
    const Image whole = splatted();
    request_.clipping = {};
    // Within half a voxel before a region's face, interpolation also reads voxels behind the face.
    EXPECT_LT(compareImages(whole, draw(store, request_)).largest, lattice == Lattice::kVoxel ? 1e-5 : 0.02);
  }
}

// Early skipping and the layout of the store do not change the picture.
TEST_P(Scenes, ClippedPicturesAreEqualForEveryBrickSizeAndVisibility) {
  request_.transfer_function = {1, {{60, {1, 0.5, 0.2}, 0}, {120, {0.4, 0.8, 1}, 0.9}}};
  request_.clipping = {VoxelBox{{22, 0, 0}, {24, 20, 13}},  // beyond the reach of the bricks on the left
                       {{{0.3, 1, 0.3}, -glm::dot(glm::dvec3(0.3, 1, 0.3), centre())}}};
  FrameStatistics statistics;
  const Image first = draw(store_, request_, 1 << 30, &statistics);
  EXPECT_LT(statistics.bricks_interesting, statistics.bricks_total);
  const auto large = makeStore(volume_, "scene_large_" + std::to_string(static_cast<int>(GetParam())), 64);
  for (const VisibilityMethod method : {VisibilityMethod::kNone, VisibilityMethod::kMask}) {
    request_.visibility.method = method;
    EXPECT_EQ(draw(store_, request_).rgba, first.rgba);
    EXPECT_EQ(draw(large, request_).rgba, first.rgba);
  }
}

// A constant gradient gives a constant factor: the picture equals the picture of the opacity times the factor.
TEST_P(Scenes, OpacityFollowsTheGradient) {
  const double slope = glm::length(worldGradient());
  request_.clipping.region = VoxelBox{{2, 0, 0}, {22, 20, 16}};  // towards the border the gradient is half as steep
  request_.transfer_function.gradient_opacity = {{0.5 * slope, 0}, {1.5 * slope, 0.8}};
  const Image modulated = splatted(), judged = reference();
  request_.transfer_function = allOver(0.4 * 0.05);
  // With opacity by gradient, no sample represents two slabs, of which the border may light one.
  EXPECT_LT(compareImages(modulated, splatted()).largest, 1e-2);
  EXPECT_LT(compareImages(judged, reference()).largest, 1e-2);
}

TEST_P(Scenes, TheBackgroundRunsFromTopToBottom) {
  request_.transfer_function = allOver(0);
  request_.background = {{0, 0.5, 0, 0.5}, {1, 0, 0, 1}};
  const Image image = splatted();
  for (int y = 0; y < kScenePixels; ++y) {
    const double t = y / (kScenePixels - 1.0);
    const double expected[] = {t, 0.5 * (1 - t), 0, 0.5 + 0.5 * t};
    for (int channel = 0; channel < 4; ++channel) EXPECT_NEAR(image.pixel(7, y)[channel], expected[channel], 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Projections, Scenes, ::testing::Values(Projection::kOrthographic, Projection::kPerspective));

}  // namespace
}  // namespace kiln::test
