// Shadows and ambient occlusion against closed forms and against rays of the reference renderer.
// Known because a layer of known depth transmits exp(-depth) of a light, an open plane sees all of its half space, and
// the reference renderer follows each shadow ray by itself.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "frame/light/illuminate.h"
#include "frame/light/shadow_views.h"
#include "image/compare.h"
#include "store/store_reader.h"
#include "support/reference/contact_sheet.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/quality_scenes.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

Light directional(const glm::dvec3& towards) {
  Light out;
  out.kind = LightKind::kDirectional;
  out.place = towards;
  return out;
}
Light pointLight(const glm::dvec3& place) {
  Light out;
  out.kind = LightKind::kPoint;
  out.place = place;
  return out;
}

// Distance from samples to the layers that shadow them. unit: world.
double startOf(const std::filesystem::path& store, FrameRequest request) {
  const StoreReader reader(store);
  BrickCache cache({&reader}, 1ull << 30, 0);
  FrameStatistics ignored;
  Progress silent;
  illuminate(cache, silent, request, ignored);
  double out = 0;
  for (const ShadowedLight& light : request.illumination->lights) out = std::max(out, light.start);
  return out;
}

constexpr int kEdge = 64;

// A floor of opaque voxels below z = 16, and a translucent layer of 16 voxels above.
DenseVolume floorUnderLayer() {
  return fill({{kEdge, kEdge, kEdge}, VoxelType::u8}, [](auto, auto, auto z) {
    return z < 16 ? 200 : z >= 32 && z < 48 ? 50 : 0;
  });
}

// Extinction is linear in the value up to 50, so that the interpolated borders of the layer keep its depth.
TransferFunction layerFunction(double extinction) {
  TransferFunction out;
  out.unit = 1;
  for (int value = 0; value <= 50; value += 2)
    out.points.push_back({static_cast<double>(value), glm::dvec3(1), 1 - std::exp(-extinction * value / 50)});
  out.points.push_back({60, glm::dvec3(1), 0.9999});
  return out;
}

// The eye sees the floor below the layer, from the side.
FrameRequest floorRequest(double extinction) {
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = {32, 32, 16};
  camera.eye = camera.target + 100.0 * glm::normalize(glm::dvec3(-1, 0, 0.2));
  camera.up = {0, 0, 1};
  camera.height = 8;
  FrameRequest request;
  request.view = resolve(camera, {96, 32});
  request.transfer_function = layerFunction(extinction);
  request.shading.ambient = request.shading.specular = 0;
  request.shading.lights = {directional({0, 0, 1})};
  return request;
}

// Mean light of the picture's middle rows.
double brightnessOf(const Image& image) {
  double sum = 0;
  int pixels = 0;
  for (int y = image.height / 4; y < 3 * image.height / 4; ++y) {
    for (int x = 0; x < image.width; ++x) sum += image.pixel(x, y)[0], ++pixels;
  }
  return sum / pixels;
}

class Shadows : public ::testing::TestWithParam<Lattice> {};

TEST_P(Shadows, OfALayerIsItsTransmittance) {
  const auto store = makeStore(floorUnderLayer(), "layer", 32);
  for (const double extinction : {0.01, 0.05, 0.15}) {
    FrameRequest request = floorRequest(extinction);
    setLattice(request, GetParam());
    const double lit = brightnessOf(draw(store, request));
    ASSERT_GT(lit, 0.2);
    request.shading.shadows = true;
    const double shadowed = brightnessOf(draw(store, request));
    EXPECT_NEAR(shadowed / lit, std::exp(-16 * extinction), 0.01) << extinction;
    request.shading.lights = {pointLight({32, 32, 4000})};
    EXPECT_NEAR(brightnessOf(draw(store, request)) / lit, std::exp(-16 * extinction), 0.01) << extinction;
    // A light between the floor and the layer is not shadowed.
    request.shading.lights = {pointLight({32, 32, 27})};
    const double near = brightnessOf(draw(store, request));
    request.shading.shadows = false;
    EXPECT_NEAR(near / brightnessOf(draw(store, request)), 1, 0.01) << extinction;
  }
}

TEST_P(Shadows, HaveAStrength) {
  const auto store = makeStore(floorUnderLayer(), "layer", 32);
  FrameRequest request = floorRequest(0.1);
  setLattice(request, GetParam());
  const double lit = brightnessOf(draw(store, request));
  request.shading.lights.front().shadow = {true, 0.25, 0, 128};
  EXPECT_NEAR(brightnessOf(draw(store, request)) / lit, 1 - 0.25 * (1 - std::exp(-1.6)), 0.01);
}

INSTANTIATE_TEST_SUITE_P(OfLattices, Shadows, ::testing::ValuesIn(kLattices),
                         [](const auto& tested) { return std::string(nameOf(tested.param)); });

// A convex body casts no shadow on its lit side. Slices are thicker than pixels, as in a scan: interpolation makes
// steps of them, whose normals differ from the body's. Each step shadowed the next in grazing light, as dark lines.
TEST(Shadows, OfABallDoNotFallOnItsLitSide) {
  constexpr double kRadius = 40;
  const glm::dvec3 middle(47.6, 47.3, 47.8);
  DenseVolume slices = fill({{96, 96, 48}, VoxelType::u8, spacingAffine({1, 1, 2})}, [&](auto x, auto y, auto z) {
    return 100 * (1 - std::erf((glm::distance(glm::dvec3(x, y, 2 * z), middle) - kRadius) / std::sqrt(2.0)));
  });
  const auto store = makeStore(slices, "slices");
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = middle, camera.eye = middle - glm::dvec3(0, 200, 0), camera.up = {0, 0, 1};
  camera.height = 2 * kRadius;
  FrameRequest request;
  request.view = resolve(camera, {320, 320});
  request.transfer_function = {1, {{60, glm::dvec3(1), 0}, {140, glm::dvec3(1), 0.95}}};
  request.shading.ambient = request.shading.specular = 0, request.shading.diffuse = 1;
  double squares = 0, darkest = 0;
  int pixels = 0;
  for (const glm::dvec3& light : {glm::dvec3(1, 0, 0.2), glm::dvec3(0.4, 0.2, 1), glm::dvec3(-0.6, -0.3, 0.7)}) {
    request.shading.lights = {directional(light)};
    request.shading.shadows = false;
    const Image lit = draw(store, request);
    request.shading.shadows = true;
    const Image shadowed = draw(store, request);
    for (int y = 0; y < lit.height; ++y) {
      for (int x = 0; x < lit.width; ++x) {
        if (glm::length(glm::dvec2(x - 159.5, y - 159.5)) > 0.9 * 160) continue;
        const double lost = lit.pixel(x, y)[0] - shadowed.pixel(x, y)[0];
        squares += lost * lost, darkest = std::max(darkest, lost), ++pixels;
      }
    }
  }
  std::printf("  light lost: %.4f rms, %.3f at most\n", std::sqrt(squares / pixels), darkest);
  EXPECT_LT(std::sqrt(squares / pixels), 0.001);
  EXPECT_LT(darkest, 0.01);
}

// A light that turns by a billionth changes no picture. Rounding made some maps a pixel longer, with all pixels moved
// by half a pixel; one of eight directions had such a map.
TEST(Shadows, OfALightThatHardlyTurnsStay) {
  const DenseVolume bar = fill({{kEdge, kEdge, kEdge}, VoxelType::u8},
                               [](auto x, auto, auto z) { return z < 16 || (z >= 48 && z < 52 && x >= 32) ? 200 : 0; });
  const auto store = makeStore(bar, "bar", 32);
  FrameRequest request = floorRequest(0.1);
  request.shading.shadows = true;
  Image first;
  for (int i = 0; i < 40; ++i) {
    request.shading.lights = {directional(glm::dvec3(0.3 + 1e-9 * i, 0.2, 1))};
    const Image image = draw(store, request);
    if (i == 0) first = image;
    float most = 0;
    for (std::size_t k = 0; k < image.rgba.size(); ++k) most = std::max(most, std::abs(image.rgba[k] - first.rgba[k]));
    EXPECT_LT(most, 1e-3f) << i;
  }
}

// The middle of the box is always at the same place of a pixel, and the longest edge is as required.
TEST(Shadows, OfLightsThatTurnKeepThePlaceOfTheirPixels) {
  VolumeGeometry box;
  box.dims = {90, 70, 50};
  const auto corners = box.corners();
  const glm::dvec3 middle = 0.5 * (corners.front() + corners.back());
  for (const int edge_px : {kLeastShadowEdge, 255, 512}) {
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 towards(std::cos(0.01 * i), std::sin(0.01 * i), 0.3);
      const ShadowView map = shadowViews(directional(towards), corners, edge_px).front();
      const ImageSize& size = map.view.size;
      EXPECT_EQ(std::max(size.width, size.height), edge_px);
      EXPECT_EQ((size.width - size.height) % 2, 0);
      const glm::dvec3 seen(map.view.view_from_world * glm::dvec4(middle, 1));
      const glm::dvec2 at_px = map.view.centre_px + map.view.focal_px * glm::dvec2(seen);
      EXPECT_NEAR(at_px.x, 0.5 * size.width, 1e-6);
      EXPECT_NEAR(at_px.y, 0.5 * size.height, 1e-6);
    }
  }
}

// A bar of width 8 at height h above the floor casts a penumbra of width 2 h tan(angle / 2).
TEST(Shadows, OfASoftLightHaveAPenumbra) {
  const DenseVolume bar = fill({{kEdge, kEdge, kEdge}, VoxelType::u8},
                               [](auto x, auto, auto z) { return z < 16 || (z >= 48 && z < 52 && x >= 32) ? 200 : 0; });
  const auto store = makeStore(bar, "bar", 32);
  FrameRequest request = floorRequest(0.1);
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = {32, 32, 16}, camera.eye = {-300, 32, 116}, camera.up = {0, 0, 1};
  camera.height = 16;
  request.view = resolve(camera, {16, 64});
  const Image unshadowed = draw(store, request);
  const auto widthOf = [&](double softness) {
    request.shading.lights.front().shadow = {true, 1, softness, 256};
    const Image image = draw(store, request);
    int between = 0;
    for (int y = 0; y < image.height; ++y) {
      const float share = image.pixel(8, y)[0] / unshadowed.pixel(8, y)[0];
      between += share > 0.05 && share < 0.95 ? 1 : 0;
    }
    // A row of pixels covers 1/4 across the view, and so much more along the floor.
    return between * 0.25 * std::hypot(332.0, 100.0) / 100;
  };
  EXPECT_LE(widthOf(0), 3);
  EXPECT_NEAR(widthOf(20), 2 * 32 * std::tan(10 * 3.14159265 / 180), 3);
}

// Clipping removes what casts the shadow.
TEST(Shadows, OfWhatIsClippedAwayAreGone) {
  const auto store = makeStore(floorUnderLayer(), "layer", 32);
  FrameRequest request = floorRequest(0.15);
  request.clipping.planes = {{{0, 0, -1}, 24}};
  const double lit = brightnessOf(draw(store, request));
  request.shading.shadows = true;
  EXPECT_NEAR(brightnessOf(draw(store, request)) / lit, 1, 1e-3);
}

// Each volume shadows the other.
TEST(Shadows, OfSeveralVolumesFallOnEachOther) {
  const auto whole = makeStore(floorUnderLayer(), "layer", 32);
  FrameRequest request = floorRequest(0.1);
  request.volumes = {{request.transfer_function, request.shading, {}},
                     {request.transfer_function, request.shading, {}}};
  // The floor of one volume and the layer of the other.
  request.volumes[0].clipping.planes = {{{0, 0, -1}, 24}};
  request.volumes[1].clipping.planes = {{{0, 0, 1}, -24}};
  const double lit = brightnessOf(draw({whole, whole}, request));
  request.shading.shadows = true;
  for (VolumeRequest& volume : request.volumes) volume.shading.shadows = true;
  EXPECT_NEAR(brightnessOf(draw({whole, whole}, request)) / lit, std::exp(-1.6), 0.01);
}

// An open plane sees its half space; the corner of a wall sees half of it.
TEST(AmbientOcclusion, OfPlaneAndCornerAreKnown) {
  const DenseVolume corner =
      fill({{kEdge, kEdge, kEdge}, VoxelType::u8}, [](auto x, auto, auto z) { return z < 16 || x >= 48 ? 200 : 0; });
  const auto store = makeStore(corner, "corner", 32);
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = {32, 32, 16}, camera.eye = {32, 32, 200}, camera.up = {0, 1, 0};
  camera.height = 8;
  FrameRequest request;
  request.view = resolve(camera, {256, 32});  // x from 0 to 64
  request.shading.ambient = 1, request.shading.diffuse = request.shading.specular = 0;
  request.shading.occlusion = {1, 12, false};
  TransferFunction surface;
  surface.surfaces = {{100, glm::dvec3(1), 1}};
  const TransferFunction solid{1, {{60, glm::dvec3(1), 0}, {120, glm::dvec3(1), 0.99}}};
  for (const TransferFunction& function : {solid, surface}) {
    request.transfer_function = function;
    const Image image = draw(store, request);
    const auto at = [&](double x) { return image.pixel(static_cast<int>(4 * x), 16)[0]; };
    EXPECT_NEAR(at(24), 1, 0.02);
    EXPECT_LT(at(46), 0.8);
    EXPECT_GT(at(46), 0.45);
    for (int x = 30; x < 45; ++x) EXPECT_LE(at(x + 1), at(x) + 0.01) << x;  // darker and darker
  }
}

// Each point of the middle of a face sees equal matter, wherever zones of slabs and slabs divide cells of the lattice.
// Stripes were 0.05 of the light deep.
TEST(AmbientOcclusion, OfAnEvenBlockIsEven) {
  constexpr int kBlockEdge = 128;
  const auto store = makeStore(
      fill({{kBlockEdge, kBlockEdge, kBlockEdge}, VoxelType::u8}, [](auto, auto, auto) { return 100; }), "block", 64);
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = glm::dvec3(kBlockEdge / 2), camera.eye = {kBlockEdge / 2, -200, kBlockEdge / 2},
  camera.up = {0, 0, 1};
  camera.height = kBlockEdge;
  FrameRequest request;
  request.view = resolve(camera, {128, 128});
  request.transfer_function.points = {{99, glm::dvec3(1), 0.3}, {101, glm::dvec3(1), 0.3}};
  request.shading.ambient = 1, request.shading.diffuse = request.shading.specular = 0;
  request.shading.occlusion = {1, 12, false};
  const Image image = draw(store, request);
  float least = 1, most = 0;
  for (int y = 24; y < 104; ++y)
    least = std::min(least, image.pixel(64, y)[0]), most = std::max(most, image.pixel(64, y)[0]);
  std::printf("  block: light from %.4f to %.4f\n", static_cast<double>(least), static_cast<double>(most));
  EXPECT_GT(least, 0.99f * most);
  EXPECT_GT(least, 0.1f);
}

// A ball, and its radius on pictures of 256 pixels.
constexpr double kBallRadius = 50.3, kBallRadiusPx = 2 * kBallRadius;
std::filesystem::path ballStore() {
  constexpr int kBallEdge = 128;
  return makeStore(ball({{kBallEdge, kBallEdge, kBallEdge}, VoxelType::u8}, glm::dvec3(63.7), kBallRadius, 200), "ball",
                   64);
}
FrameRequest ballRequest() {
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = glm::dvec3(63.7), camera.eye = {150, -180, 260}, camera.up = {0, 1, 0};
  camera.height = 128;
  FrameRequest request;
  request.view = resolve(camera, {256, 256});
  request.shading.ambient = 1, request.shading.diffuse = request.shading.specular = 0;
  request.shading.occlusion = {1, 12, false};
  return request;
}

// Nothing is in the way of a ball's surface: its light is even, without rings where the surface crosses cells of the
// grid. Points 1.5 cells apart gave a deviation of 0.031.
TEST(AmbientOcclusion, OfABallHasNoRings) {
  FrameRequest request = ballRequest();
  request.transfer_function.surfaces = {{100, glm::dvec3(1), 1}};
  const Image image = draw(ballStore(), request);
  double n = 0, sum = 0, squares = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (glm::length(glm::dvec2(x - 127.5, y - 127.5)) > 0.8 * kBallRadiusPx) continue;
      const double light = image.pixel(x, y)[0];
      n += 1, sum += light, squares += light * light;
    }
  }
  const double mean = sum / n, deviation = std::sqrt(squares / n - mean * mean);
  std::printf("  ball: mean %.4f, deviation %.4f\n", mean, deviation);
  EXPECT_NEAR(mean, 1, 0.005);
  EXPECT_LT(deviation, 0.003);
}

// Samples of rays that graze a ball lie behind its contour. Their reversed normals point into the ball, where a look-up
// finds no light: a dark line along silhouettes. `high`: the ball's values are the higher ones.
class Silhouettes : public ::testing::TestWithParam<bool> {};
TEST_P(Silhouettes, OfABallAreNotDark) {
  FrameRequest request = ballRequest();
  const glm::dvec3 white(1);
  request.transfer_function.points = {{60, white, 0}, {120, white, 0.9}};
  auto store = ballStore();
  if (!GetParam()) {
    DenseVolume hole = ball({{128, 128, 128}, VoxelType::u8}, glm::dvec3(63.7), kBallRadius, 200);
    for (std::byte& byte : hole.voxels) byte = static_cast<std::byte>(200 - static_cast<int>(byte));
    store = makeStore(hole, "hole", 64);
    request.transfer_function.points = {{80, white, 0.9}, {140, white, 0}};
  }
  const Image image = draw(store, request);
  double least = 1;
  int edge = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float* const pixel = image.pixel(x, y);
      const double from_middle = glm::length(glm::dvec2(x - 127.5, y - 127.5));
      if (pixel[3] < 0.05f || std::abs(from_middle - kBallRadiusPx) > 6) continue;
      ++edge;
      least = std::min(least, static_cast<double>(pixel[0] / pixel[3]));
    }
  }
  std::printf("  least light of %d pixels at the silhouette: %.3f\n", edge, least);
  EXPECT_GT(edge, 1000);
  EXPECT_GT(least, 0.9);
}
INSTANTIATE_TEST_SUITE_P(Of, Silhouettes, ::testing::Bool());

// Rays near the edge of a cube of matter leave through the volume's border. The normal of a face that looks away from
// the eye, turned to the eye, points into the cube.
TEST(Silhouettes, OfTheVolumesBorderAreNotDark) {
  const auto store =
      makeStore(fill({{kEdge, kEdge, kEdge}, VoxelType::u8}, [](auto, auto, auto) { return 200; }), "cube", 32);
  FrameRequest request = ballRequest();
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = glm::dvec3(kEdge / 2), camera.eye = {90, -110, 130}, camera.up = {0, 0, 1};
  camera.height = 2 * kEdge;
  request.view = resolve(camera, {256, 256});
  request.transfer_function = {1, {{60, glm::dvec3(1), 0}, {120, glm::dvec3(1), 0.9}}};
  const Image image = draw(store, request);
  double least = 1;
  int drawn = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float* const pixel = image.pixel(x, y);
      if (pixel[3] < 0.05f) continue;
      ++drawn;
      least = std::min(least, static_cast<double>(pixel[0] / pixel[3]));
    }
  }
  std::printf("  least light of %d pixels: %.3f\n", drawn, least);
  EXPECT_GT(drawn, 10000);
  EXPECT_GT(least, 0.8);
}

// At a sharp edge between a face that the light reaches and a hidden face, samples of rays that graze the edge have
// normals that point far away from the eye.
TEST(Silhouettes, OfSharpEdgesOfLabelsAreNotDark) {
  const auto within = [](auto i) { return i >= 16 && i < 48; };
  const DenseVolume box = fill({{kEdge, kEdge, kEdge}, VoxelType::u8},
                               [&](auto i, auto j, auto k) { return within(i) && within(j) && within(k) ? 1 : 0; });
  FrameRequest request;
  Camera camera;
  camera.target = glm::dvec3(32), camera.eye = {92, -118, 92}, camera.up = {0, 0, 1};
  camera.fov_deg = 30;
  request.view = resolve(camera, {320, 320});
  request.transfer_function.labels = {{1, "box", glm::dvec3(1), 1}};
  request.shading.lights = {{.kind = LightKind::kCamera, .place = {-1, 1, 1}}};
  const Image image = draw(makeStore(box, "box_of_a_label", 32, true), request);
  const auto light = [&](int x, int y) { return image.pixel(x, y)[0] / image.pixel(x, y)[3]; };
  int columns = 0;
  for (int x = 0; x < image.width; ++x) {
    int y = 0;
    while (y < image.height && image.pixel(x, y)[3] < 0.05f) ++y;
    // Columns that enter the box through its upper face.
    if (y > image.height / 2 - 40) continue;
    ++columns;
    EXPECT_GT(light(x, y), 0.85f * light(x, y + 4)) << x;
  }
  EXPECT_GT(columns, 60);
}

TEST(AmbientOcclusion, OfStrengthZeroChangesNoBit) {
  const auto store = makeStore(floorUnderLayer(), "layer", 32);
  FrameRequest request = floorRequest(0.1);
  request.shading.ambient = 0.5;
  const Image plain = draw(store, request);
  request.shading.occlusion = {0, 10, true};
  EXPECT_TRUE(equalBits(plain, draw(store, request)));
}

// Correlation of the first channels of pixels that are opaque in both pictures, and the ratio of their means.
struct Agreement {
  double correlation = 0, ratio = 0;
};
Agreement agreementOf(const Image& a, const Image& b) {
  double n = 0, sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      if (a.pixel(x, y)[3] < 0.99f || b.pixel(x, y)[3] < 0.99f) continue;
      const double p = a.pixel(x, y)[0], q = b.pixel(x, y)[0];
      n += 1, sum_a += p, sum_b += q, aa += p * p, bb += q * q, ab += p * q;
    }
  }
  const double covariance = ab - sum_a * sum_b / n;
  return {covariance / std::sqrt((aa - sum_a * sum_a / n) * (bb - sum_b * sum_b / n)), sum_a / sum_b};
}

// Scans against random rays from each sample.
struct OccludedScan {
  const char* volume;
  double correlation;  // at least
};
class OcclusionOfScans : public ::testing::TestWithParam<OccludedScan> {};
TEST_P(OcclusionOfScans, IsNearMonteCarlo) {
  const QualityVolume& volume = qualityVolume(GetParam().volume);
  const std::filesystem::path file = std::filesystem::path(KILN_TEST_DATA_DIR) / volume.file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no test data: " << file;
  const DenseVolume dense = readVolume(file);
  const auto store = makeStore(dense, "scan", 64);
  FrameRequest request;
  request.view = resolve(cameraOf(volume, dense.geometry, Projection::kOrthographic, 0.35, 80), {80, 80});
  request.level = 0;
  request.transfer_function = transferFunctionOf(volume, Material::kSkin);
  for (auto& point : request.transfer_function.points) point.color = glm::dvec3(1);
  request.samples = 4;
  request.shading.ambient = 1, request.shading.diffuse = request.shading.specular = 0;
  request.shading.occlusion = {1, 0.1 * static_cast<double>(dense.geometry.dims.x) * dense.geometry.meanSpacing(),
                               false};
  ReferenceSettings settings;
  settings.rays_per_axis = 2;
  settings.step_voxels = 0.5;
  settings.opacity_threshold = request.opacity_threshold;
  settings.occlusion_rays = 16;
  settings.occlusion_start = dense.geometry.meanSpacing();
  const Image truth =
      referenceImage(dense, request.view, request.transfer_function, request.shading, {0, 0, 0, 0}, settings);
  const Image image = draw(store, request);
  const Agreement found = agreementOf(image, truth);
  std::printf("  %s: correlation %.4f, mean %+.2f %%\n", GetParam().volume, found.correlation, 100 * (found.ratio - 1));
  writeContactSheet({{image, truth}}, 480, fmt::format("occlusion_{}.png", GetParam().volume));
  EXPECT_GE(found.correlation, GetParam().correlation);
  EXPECT_NEAR(found.ratio, 1, 0.03);
}
INSTANTIATE_TEST_SUITE_P(Of, OcclusionOfScans, ::testing::Values(OccludedScan{"engine", 0.955}));
INSTANTIATE_TEST_SUITE_P(NightlyOf, OcclusionOfScans,
                         ::testing::Values(OccludedScan{"cthead", 0.96}, OccludedScan{"vhm_head", 0.945}));

// Tiles, threads, budgets, bricks and crops change no bit.
TEST(Illumination, DependsOnTheSceneAlone) {
  const DenseVolume volume = head({{80, 102, 74}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8));
  const auto store = makeStore(volume, "head", 16), large = makeStore(volume, "large", 64);
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {-0.5, -1, 0.3}, Projection::kPerspective), {150, 130});
  request.level = 0;
  request.transfer_function = {0, {{60, {1, 0.8, 0.7}, 0}, {100, {1, 0.8, 0.7}, 0.1}, {200, {1, 1, 1}, 0.9}}};
  request.shading.ambient = 0.4;
  request.shading.shadows = true;
  request.shading.lights = {directional({-1, -1, 1}), pointLight(volume.geometry.worldOf({100, -20, 80})), Light{}};
  request.shading.occlusion = {0.8, 0, true};
  const Image whole = draw(store, request);
  ASSERT_TRUE(showsSomething(whole));
  EXPECT_TRUE(equalBits(whole, draw(large, request)));
  EXPECT_TRUE(equalBits(whole, draw(store, request, 8 << 20)));
  FrameRequest other = request;
  other.tile_px = 128, other.bricks_together = 3, other.visibility.method = VisibilityMethod::kNone;
  EXPECT_TRUE(equalBits(whole, draw(store, other)));
  other = request;
  other.crop = PixelRect{37, 41, 120, 99};
  EXPECT_TRUE(equalBits(partOf(whole, *other.crop), draw(store, other)));
  FrameRequest unlit = request;
  unlit.shading.shadows = false, unlit.shading.occlusion = {};
  EXPECT_FALSE(equalBits(whole, draw(store, unlit)));
}

struct Scan {
  const char* volume;
  Material material;
  bool point;
};

class ShadowsOfScans : public ::testing::TestWithParam<Scan> {};

// Pictures of scans against rays. A sheet stays in the test's output: ours, the reference's, and without shadows.
TEST_P(ShadowsOfScans, AreNearTheReference) {
  const Scan& scan = GetParam();
  const QualityVolume& volume = qualityVolume(scan.volume);
  const std::filesystem::path file = std::filesystem::path(KILN_TEST_DATA_DIR) / volume.file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no test data: " << file;
  const DenseVolume dense = readVolume(file);
  const auto store = makeStore(dense, "scan", 64);
  FrameRequest request;
  request.view = resolve(cameraOf(volume, dense.geometry, Projection::kOrthographic, 0.7, 160), {160, 160});
  request.transfer_function = transferFunctionOf(volume, scan.material);
  request.samples = 4;
  request.shading.shadows = true;
  const glm::dvec3 to_eye = glm::normalize(volume.from), up = glm::normalize(volume.up);
  const glm::dvec3 to_light = glm::normalize(to_eye + 0.7 * up + 0.8 * glm::cross(up, to_eye));
  const glm::dvec3 middle =
      dense.geometry.worldOf(0.5 * glm::dvec3(dense.geometry.dims.x, dense.geometry.dims.y, dense.geometry.dims.z));
  const double away = 1.2 * static_cast<double>(dense.geometry.dims.x) * dense.geometry.meanSpacing();
  request.shading.lights = {scan.point ? pointLight(middle + away * to_light) : directional(to_light)};
  ReferenceSettings settings;
  settings.rays_per_axis = 2;
  settings.step_voxels = 0.5;
  settings.opacity_threshold = request.opacity_threshold;
  settings.shadow_start = startOf(store, request);
  const Image truth =
      referenceImage(dense, request.view, request.transfer_function, request.shading, {0, 0, 0, 0}, settings);
  const Image image = draw(store, request);
  FrameRequest flat = request;
  flat.shading.shadows = false;
  const Image without = draw(store, flat);
  const ImageDifference difference = compareImages(truth, image), none = compareImages(truth, without);
  std::printf("  %s %s, %s: %.1f dB (without shadows %.1f), brightness %+.2f %%\n", scan.volume, nameOf(scan.material),
              scan.point ? "point" : "directional", difference.foreground_psnr_db, none.foreground_psnr_db,
              100 * (difference.mean_brightness_ratio - 1));
  writeContactSheet({{image, truth, without}}, 480,
                    fmt::format("shadows_{}_{}_{}.png", scan.volume, nameOf(scan.material), scan.point));
  EXPECT_GE(difference.foreground_psnr_db, 36);
  EXPECT_NEAR(difference.mean_brightness_ratio, 1, 0.005);
}

INSTANTIATE_TEST_SUITE_P(
    OfLights, ShadowsOfScans,
    ::testing::Values(Scan{"cthead", Material::kSkin, false}, Scan{"cthead", Material::kBoneInSkin, true},
                      Scan{"vhm_head", Material::kBoneInSkin, false}, Scan{"vhm_head", Material::kSkin, true},
                      Scan{"engine", Material::kBoneInSkin, false}, Scan{"engine", Material::kSkin, true}));

}  // namespace
}  // namespace kiln::test
