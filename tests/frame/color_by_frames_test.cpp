// Colours of another volume. Opacity stays the volume's own, so that alpha is equal to the bit; colours depend on
// positions alone, whatever the bricks, budgets, tiles and threads.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/thread/parallel.h"
#include "support/reference/companions.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

using Path = std::filesystem::path;
constexpr ImageSize kColorSize{90, 77};

Image drawColored(const Path& store, const Path& values, const FrameRequest& request,
                  std::uint64_t budget_bytes = 1ull << 30) {
  return draw(*withValues(store, values), request, budget_bytes);
}

std::shared_ptr<const CompanionColors> colorsByFunction(const TransferFunction& function, const DenseVolume& values) {
  return std::make_shared<const CompanionColors>(CompanionColors{function, values.type, values.range()});
}

FrameRequest colorRequest(std::uint64_t seed, const DenseVolume& volume) {
  const RandomScene scene = randomScene(seed, volume, kColorSize);
  FrameRequest out = requestOf(scene, Lattice::kPixel, randomThreshold(seed));
  out.level = 0;  // smaller bricks have more levels
  out.visibility.method = VisibilityMethod::kNone;
  return out;
}

// The other volume has another resolution and is turned against the volume.
DenseVolume turnedValues() {
  const glm::dmat4 turned = turnedAffine(0.4, {1.3, 2.2, 1.7}, {10, -10, 15});
  return head({{50, 31, 42}, VoxelType::i16, turned}, usualRange(VoxelType::i16));
}

// Known because none of the varied options is part of the picture's definition.
TEST(ColorBy, IsDrawnAlikeByBricksThreadsTilesMemoryAndCrops) {
  const DenseVolume volume = cheese({{75, 61, 70}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  const DenseVolume values = turnedValues();
  const Path large = makeStore(volume, "large", 128), small = makeStore(volume, "small", 16);
  const Path large_values = makeStore(values, "large_values", 64), small_values = makeStore(values, "small_values", 16);
  int shown = 0;
  for (std::uint64_t seed = 720; seed < casesOf(725u, 721u); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = colorRequest(seed, volume);
    Random random(seed);
    request.colors = colorsByFunction(randomTransferFunction(random, values.range(), 1), values);
    const Image truth = drawColored(large, large_values, request), plain = draw(large, request);
    shown += showsSomething(truth) ? 1 : 0;
    for (std::size_t at = 3; at < truth.rgba.size(); at += 4) ASSERT_EQ(truth.rgba[at], plain.rgba[at]) << "alpha";
    EXPECT_TRUE(equalBits(truth, drawColored(small, large_values, request))) << "bricks of 16";
    EXPECT_TRUE(equalBits(truth, drawColored(small, small_values, request))) << "bricks of 16 of both";
    request.visibility.method = VisibilityMethod::kMask;
    EXPECT_TRUE(equalBits(truth, drawColored(small, small_values, request))) << "tested for visibility";
    const ThreadLimit one(1);
    const std::uint64_t least = withValues(small, small_values)->largestReadBytes();
    EXPECT_TRUE(equalBits(truth, drawColored(small, small_values, request, least))) << "least memory";
    request.tile_px = 128;
    request.crop = PixelRect{21, 13, 70, 57};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), drawColored(small, small_values, request))) << "cropped";
  }
  EXPECT_GT(shown, casesOf(2, 0));
}

// A volume coloured by itself has its own colours.
TEST(ColorBy, ItselfChangesNoColour) {
  const DenseVolume volume = cheese({{45, 51, 40}, VoxelType::u8}, 1, {0, 255});
  const Path store = makeStore(volume, "volume", 16);
  for (const bool surface : {false, true}) {
    FrameRequest request = colorRequest(91, volume);
    request.interpolation = Interpolation::kLinear;  // as values of companions are interpolated
    request.transfer_function = {1, {{40, {1, 0, 0}, 0}, {128, {0, 1, 0}, 0.2}, {255, {0, 0, 1}, 0.4}}};
    request.colors = colorsByFunction(request.transfer_function, volume);
    if (surface) request.transfer_function.points.clear(), request.transfer_function.surfaces = {{128, {0, 1, 0}, 1}};
    const Image own = draw(store, request), colored = drawColored(store, store, request);
    EXPECT_TRUE(showsSomething(own));
    for (std::size_t at = 0; at < own.rgba.size(); ++at)
      ASSERT_NEAR(own.rgba[at], colored.rgba[at], surface ? 0.02 : 1e-4);
  }
}

// A volume elsewhere colours nothing.
TEST(ColorBy, AVolumeElsewhereChangesNoBit) {
  const DenseVolume volume = cheese({{45, 51, 40}, VoxelType::f32}, 1, {0, 1});
  const DenseVolume values = fill({{20, 20, 20}, VoxelType::u8, spacingAffine(glm::dvec3(1), glm::dvec3(500))},
                                  [](auto x, auto, auto) { return x; });
  const Path store = makeStore(volume, "volume", 16), far = makeStore(values, "far", 16);
  FrameRequest request = colorRequest(92, volume);
  request.transfer_function = {1, {{0, {1, 0, 0}, 0.01}, {1, {0, 1, 0}, 0.2}}};
  const Image plain = draw(store, request);
  request.colors = colorsByFunction({1, {{0, {0, 0, 1}, 1}}}, values);
  EXPECT_TRUE(showsSomething(plain));
  EXPECT_TRUE(equalBits(plain, drawColored(store, far, request)));
}

// Half of a uniform medium has the label 2, half of it the label 5, which has no colour.
TEST(ColorBy, LabelsColourByTheNearestVoxel) {
  const DenseVolume volume = fill({{40, 40, 40}, VoxelType::u8}, [](auto...) { return 9; });
  const DenseVolume labels = fill({{20, 20, 20}, VoxelType::u8, spacingAffine(glm::dvec3(2), glm::dvec3(0.5))},
                                  [](auto x, auto, auto) { return x < 10 ? 2 : 5; });
  const Path store = makeStore(volume, "volume", 16), of_labels = makeStore(labels, "labels", 16, true);
  FrameRequest request;
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.eye = {19.5, 19.5, -100}, camera.target = {19.5, 19.5, 19.5}, camera.up = {0, 1, 0};
  camera.height = 40;
  request.view = resolve(camera, {40, 40});
  request.transfer_function = {1, {{0, glm::dvec3(1, 0, 0), 0.1}}};
  request.shading.phong = false;
  request.filters_rays = false;  // the filter mixes neighbouring pixels
  TransferFunction function;
  function.labels = {{2, "", glm::dvec3(0, 0, 1), 1}};
  request.colors = colorsByFunction(function, labels);
  const Image image = drawColored(store, of_labels, request);
  int blue = 0, red = 0;
  for (int x = 0; x < 40; ++x) {
    const float* const pixel = image.pixel(x, 20);
    SCOPED_TRACE(fmt::format("{} {} {} {} {}", x, pixel[0], pixel[1], pixel[2], pixel[3]));
    EXPECT_TRUE(pixel[0] == 0 || pixel[2] == 0);
    EXPECT_GT(pixel[3], 0.9f);
    blue += pixel[2] > 0.9f && pixel[0] == 0 ? 1 : 0;
    red += pixel[0] > 0.9f && pixel[2] == 0 ? 1 : 0;
  }
  EXPECT_EQ(blue, 20);
  EXPECT_EQ(red, 20);
}

// A ball of the label 2 in the label 5, which has a colour, and no label, which has none. All that a mask or a volume
// of labels shows is inside of the ball. Values are NaN outside of the ball.
TEST(ColorBy, HiddenVoxelsColourNoSurfaceOfAMaskOrLabel) {
  const VolumeShape shape{{40, 40, 40}, VoxelType::u8};
  const auto inside = [](auto x, auto y, auto z) {
    return glm::distance(glm::dvec3(x, y, z), glm::dvec3(19.3, 19.6, 19.8)) < 13.4;
  };
  const DenseVolume volume = fill(shape, [](auto...) { return 9; });
  const DenseVolume labels = fill(shape, [&](auto x, auto y, auto z) { return inside(x, y, z) ? 2 : x < 20 ? 5 : 0; });
  const DenseVolume values = fill({shape.dims, VoxelType::f32}, [&](auto x, auto y, auto z) {
    return inside(x, y, z) ? 2 + 0.01 * static_cast<double>(x) : std::nan("");
  });
  const Path store = makeStore(volume, "volume", 16), large = makeStore(volume, "large", 64);
  const Path of_labels = makeStore(labels, "labels", 16, true), of_values = makeStore(values, "values", 16);
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {-0.3, -1, 0.4}, Projection::kPerspective), kColorSize);
  request.transfer_function = {1, {{0, glm::dvec3(1, 0, 0), 0.9}}};
  request.shading.phong = false;
  TransferFunction by_label;
  by_label.labels = {{2, "", glm::dvec3(0, 0, 1), 1}, {5, "", glm::dvec3(0, 1, 0), 1}};
  const TransferFunction by_value{1, {{2, glm::dvec3(0, 0, 1), 1}, {3, glm::dvec3(0, 0, 1), 1}}};
  TransferFunction balls;
  balls.labels = {{2, "", glm::dvec3(1, 0, 0), 1}};
  const Path ball = makeStore(labels, "ball", 16, true), large_ball = makeStore(labels, "large_ball", 64, true);
  for (const bool named : {true, false}) {
    const Path& colors = named ? of_labels : of_values;
    request.colors = named ? colorsByFunction(by_label, labels) : colorsByFunction(by_value, values);
    const Image image = draw(*maskedWithValues(store, of_labels, {2}, colors), request);
    EXPECT_TRUE(equalBits(image, draw(*maskedWithValues(large, of_labels, {2}, colors), request)));
    FrameRequest of_ball = request;
    of_ball.transfer_function = balls;
    const Image labelled = drawColored(ball, colors, of_ball);
    EXPECT_TRUE(equalBits(labelled, drawColored(large_ball, colors, of_ball)));
    for (const Image* picture : {&image, &labelled}) {
      double other = 0, blue = 0;
      for (std::size_t at = 0; at < picture->rgba.size(); at += 4)
        other += picture->rgba[at] + picture->rgba[at + 1], blue += picture->rgba[at + 2];
      EXPECT_GT(blue, 500) << named;
      EXPECT_EQ(other, 0) << named;
    }
  }
}

// Labels of a segmentation by a threshold end at the iso-surface of the threshold: one voxel beside each point of the
// surface has the label 2, and the nearest voxel may have none.
TEST(ColorBy, LabelsColourTheSurfaceAtWhichTheyEnd) {
  const VolumeShape shape{{40, 40, 40}, VoxelType::u8};
  const auto valueAt = [](auto x, auto y, auto z) {
    return std::clamp(100 + 20 * (13.4 - glm::distance(glm::dvec3(x, y, z), glm::dvec3(19.3, 19.6, 19.8))), 0.0, 200.0);
  };
  const DenseVolume volume = fill(shape, valueAt);
  const DenseVolume labels = fill(shape, [&](auto x, auto y, auto z) { return valueAt(x, y, z) >= 100 ? 2 : 0; });
  const Path store = makeStore(volume, "volume", 16), of_labels = makeStore(labels, "labels", 16, true);
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {-0.3, -1, 0.4}, Projection::kPerspective), kColorSize);
  request.transfer_function.surfaces = {{100, glm::dvec3(1, 0, 0), 1}};
  request.shading.phong = false;
  TransferFunction function;
  function.labels = {{2, "", glm::dvec3(0, 0, 1), 1}};
  request.colors = colorsByFunction(function, labels);
  const Image image = drawColored(store, of_labels, request);
  double red = 0, blue = 0;
  for (std::size_t at = 0; at < image.rgba.size(); at += 4) red += image.rgba[at], blue += image.rgba[at + 2];
  EXPECT_GT(blue, 500);
  EXPECT_EQ(red, 0);
}

}  // namespace
}  // namespace kiln::test
