// A picture does not depend on the magnitude of its inputs: values, lengths, light and footprints. Known because a
// change of units leaves the picture as it is, and scaling by a power of two keeps all digits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "image/compare.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kScaleSize{64, 60};

// A ball of values up to 30 beside a ball of half the size.
DenseVolume balls(double values, double spacing) {
  DenseVolume out = fill({{40, 36, 33}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    const glm::dvec3 at(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    const auto ball = [&](const glm::dvec3& centre, double radius) {
      return std::max(0.0, 30 * (1 - glm::length(at - centre) / radius));
    };
    return values * std::max(ball({14, 17, 16}, 13), ball({30, 17, 16}, 9));
  });
  for (int a = 0; a < 3; ++a) out.geometry.world_from_index[a][a] = spacing;
  return out;
}

FrameRequest requestFor(const DenseVolume& volume, Lattice lattice, double values, double spacing) {
  FrameRequest request;
  setLattice(request, lattice);
  request.level = 0;
  request.transfer_function = {spacing, {{9 * values, {0.9, 0.7, 0.5}, 0}, {13 * values, {0.8, 0.7, 0.6}, 0.8}}};
  request.view = resolve(cameraFrom(volume.geometry, {0.6, -1, 0.3}, Projection::kPerspective), kScaleSize);
  return request;
}

class Scale : public ::testing::TestWithParam<Lattice> {};

TEST_P(Scale, OfValuesChangesNothing) {
  const auto drawn = [&](double values, bool two_lights) {
    const DenseVolume volume = balls(values, 1);
    FrameRequest request = requestFor(volume, GetParam(), values, 1);
    if (two_lights) request.shading.lights.push_back({LightKind::kDirectional, {1, -1, 0.5}, {0.4, 0.6, 0.8}, 0.7});
    request.aovs.normal = two_lights;
    if (two_lights) request.transfer_function.gradient_opacity = {{0.5 * values, 0.2}, {2 * values, 1}};
    return draw(makeStore(volume, "values", 16), request);
  };
  for (const bool two_lights : {false, true}) {
    const Image usual = drawn(1, two_lights);
    ASSERT_TRUE(showsSomething(usual));
    for (const double values : {0x1p60, 0x1p-60, 0x1p90, 0x1p-90})
      EXPECT_TRUE(equalBits(drawn(values, two_lights), usual)) << values << (two_lights ? ", two lights" : "");
  }
}

TEST_P(Scale, OfLengthsChangesNothing) {
  const auto drawn = [&](double spacing) {
    const DenseVolume volume = balls(1, spacing);
    return draw(makeStore(volume, "lengths", 16), requestFor(volume, GetParam(), 1, spacing));
  };
  const Image usual = drawn(1);
  for (const double spacing : {0x1p-20, 0x1p20}) EXPECT_TRUE(equalBits(drawn(spacing), usual)) << spacing;
}

// A factor of the light scales each colour, up to the rounding of sums.
TEST_P(Scale, OfLightIsThatOfThePicture) {
  const DenseVolume volume = balls(1, 1);
  const auto store = makeStore(volume, "light", 16);
  FrameRequest request = requestFor(volume, GetParam(), 1, 1);
  request.shading.ambient = 0;
  const Image usual = draw(store, request);
  for (const double light : {512.0, 65536.0, 1048576.0}) {
    request.shading.lights[0].intensity = light;
    const Image bright = draw(store, request);
    double worst = 0;
    for (std::size_t i = 0; i < usual.rgba.size(); ++i) {
      const double scale = i % 4 == 3 ? 1 : light;
      worst =
          std::max(worst, std::abs(static_cast<double>(bright.rgba[i]) / scale - static_cast<double>(usual.rgba[i])));
    }
    EXPECT_LT(worst, 2e-4) << light;
  }
  request.shading.lights[0].intensity = 1;
  request.shading.ambient = 1000;
  const Image ambient = draw(store, request);
  EXPECT_GE(*std::min_element(ambient.rgba.begin(), ambient.rgba.end()), 0);
}

// The brightest of several lit volumes determines the scale, independent of order.
TEST(Scales, OfLightAreThoseOfAnyVolume) {
  const DenseVolume volume = balls(1, 1);
  const auto store = makeStore(volume, "lights", 16);
  FrameRequest request = requestFor(volume, Lattice::kPixel, 1, 1);
  Shading bright, matte;
  bright.lights[0].intensity = 4096;
  matte.phong = false;
  Clipping left, right;
  left.region = VoxelBox{{0, 0, 0}, {20, 36, 33}}, right.region = VoxelBox{{20, 0, 0}, {40, 36, 33}};
  request.volumes = {{request.transfer_function, matte, left}, {request.transfer_function, bright, right}};
  const Image first = draw({store, store}, request);
  std::swap(request.volumes[0], request.volumes[1]);
  const Image second = draw({store, store}, request);
  float worst = 0;
  for (std::size_t i = 0; i < first.rgba.size(); ++i)
    worst = std::max(worst, std::abs(first.rgba[i] - second.rgba[i]) / 4096);
  EXPECT_LT(worst, 1e-3f);
  EXPECT_GT(*std::max_element(first.rgba.begin(), first.rgba.end()), 1000);
  EXPECT_GE(*std::min_element(first.rgba.begin(), first.rgba.end()), 0);
}

// An infinite voxel shows the first or the last point of the transfer function.
TEST_P(Scale, OfAnInfiniteBodyIsTheFunctionsEnd) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  for (const float inside : {kInfinite, -kInfinite}) {
    const DenseVolume volume = fill({{24, 24, 24}, VoxelType::f32}, [&](auto i, auto j, auto k) {
      const bool in = std::min({i, j, k}) >= 6 && std::max({i, j, k}) < 18;
      return in ? static_cast<double>(inside) : 10.0;
    });
    FrameRequest request = requestFor(volume, GetParam(), 1, 1);
    request.transfer_function = {1, {{0, {0, 0, 1}, 0.9}, {9, {0, 0, 1}, 0}, {11, {1, 0, 0}, 0}, {20, {1, 0, 0}, 0.9}}};
    request.shading.phong = false;
    const Image image = draw(makeStore(volume, "infinite", 16), request);
    const float* const middle = &image.rgba[4 * static_cast<std::size_t>(30 * kScaleSize.width + 32)];
    EXPECT_GT(middle[3], 0.9f) << inside;
    EXPECT_GT(middle[inside > 0 ? 0 : 2], 0.9f) << inside;
    EXPECT_LT(middle[inside > 0 ? 2 : 0], 0.05f) << inside;
  }
}

INSTANTIATE_TEST_SUITE_P(Lattices, Scale, ::testing::ValuesIn(kLattices),
                         [](const auto& lattice) { return nameOf(lattice.param); });

// Samples of close views are hundreds of pixels apart. Sample buffers do not grow with this distance, and tiles are
// independent.
TEST(CloseUps, TakeNoMoreMemoryThanOthers) {
  const DenseVolume volume = balls(1, 1);
  const auto store = makeStore(volume, "close", 16);
  for (const double zoom : {60.0, 400.0, 4000.0}) {
    FrameRequest request = requestFor(volume, Lattice::kPixel, 1, 1);
    Camera camera = cameraFrom(volume.geometry, {0.6, -1, 0.3}, Projection::kOrthographic);
    camera.height /= zoom;
    request.view = resolve(camera, {128, 128});
    FrameStatistics statistics;
    request.tile_px = 64;
    const Image image = draw(store, request, 1ull << 30, &statistics);
    EXPECT_TRUE(showsSomething(image)) << zoom;
    EXPECT_LT(statistics.slab_bytes, 16u << 20) << zoom;  // a sheet of all footprints would take 10 GiB
    request.tile_px = 128;
    EXPECT_TRUE(equalBits(draw(store, request), image)) << zoom;
  }
}

}  // namespace
}  // namespace kiln::test
