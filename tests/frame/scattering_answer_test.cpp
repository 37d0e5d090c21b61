// Light scattered once by a medium, against closed forms and against rays of the reference renderer.
// Known because a homogeneous slab of extinction e sends ∫ e·exp(-e s)·exp(-e d(s)) ds times the phase function, with
// the depth s along the view and the length d(s) of the light's way through the slab.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "image/compare.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Layers of voxels of the slab; far borders are beyond the way of the light.
constexpr int kLayers = 24, kWide = 160;
constexpr double kWhiteAlbedo = 0.9;

TransferFunction mediumOf(double extinction, double anisotropy) {
  TransferFunction out{1, {{0, glm::dvec3(1), 1 - std::exp(-extinction)}}};
  out.scattering = {kWhiteAlbedo, anisotropy};
  return out;
}

// The eye looks down on the slab.
FrameRequest slabRequest(const TransferFunction& function) {
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = glm::dvec3(0.5 * kWide, 0.5 * kWide, 0.5 * kLayers);
  camera.eye = camera.target + glm::dvec3(0, 0, 200);
  camera.up = {0, 1, 0};
  camera.height = 8;
  FrameRequest request;
  request.view = resolve(camera, {16, 16});
  request.transfer_function = function;
  request.opacity_threshold = 1;
  request.shading.ambient = request.shading.specular = 0;
  request.shading.diffuse = 1;
  request.shading.shadows = true;
  return request;
}

// Light of the slab, scattered towards the eye. `towards`: the light, whose z is not 0.
double lightOfSlab(double extinction, double anisotropy, const glm::dvec3& towards) {
  const glm::dvec3 direction = glm::normalize(towards);
  const double across = 1 / std::abs(direction.z), depth = kLayers * extinction;
  const double phase = Scattering{1, anisotropy}.phase(-direction.z);
  if (direction.z > 0) return kWhiteAlbedo * phase * (1 - std::exp(-depth * (1 + across))) / (1 + across);
  // From behind: the way of the light is the rest of the slab.
  const double rise = across - 1;
  const double passed = std::abs(rise) < 1e-9 ? depth : (std::exp(depth * rise) - 1) / rise;
  return kWhiteAlbedo * phase * std::exp(-depth * across) * passed;
}

class ScatteringOf : public ::testing::TestWithParam<Lattice> {};

TEST_P(ScatteringOf, ASlabIsTheClosedForm) {
  const auto store =
      makeStore(fill({{kWide, kWide, kLayers}, VoxelType::u8}, [](auto...) { return 100.0; }), "slab", 64);
  for (const double extinction : {0.02, 0.1}) {
    for (const double anisotropy : {-0.4, 0.0, 0.6}) {
      FrameRequest request = slabRequest(mediumOf(extinction, anisotropy));
      setLattice(request, GetParam());
      for (const glm::dvec3& towards : {glm::dvec3(0, 0, 1), glm::dvec3(0.6, 0.3, 1), glm::dvec3(0.4, -0.2, -1)}) {
        request.shading.lights = {Light{LightKind::kDirectional, towards}};
        const double expected = lightOfSlab(extinction, anisotropy, towards);
        // A voxel of the voxel lattice is a single sample, as thick as the voxel.
        const double error = GetParam() == Lattice::kPixel ? 0.01 : 0.12;
        EXPECT_NEAR(draw(store, request).pixel(8, 8)[0] / expected, 1, error)
            << extinction << ' ' << anisotropy << ' ' << towards.x << ' ' << towards.z;
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(OfLattices, ScatteringOf, ::testing::ValuesIn(kLattices),
                         [](const auto& tested) { return std::string(nameOf(tested.param)); });

// A light has no direction at its own place, where samples of voxels lie.
TEST(Scattering, ALightAtAVoxel_isFinite) {
  const auto store = makeStore(fill({{32, 32, 32}, VoxelType::u8}, [](auto, auto, auto) { return 0; }), "medium", 32);
  FrameRequest request = slabRequest(mediumOf(0.05, 0.3));
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = {16, 16, 16}, camera.eye = {16, 16, 200}, camera.up = {0, 1, 0};
  camera.height = 32;
  request.view = resolve(camera, {64, 64});
  request.lattice = Lattice::kVoxel;
  request.shading.shadows = false;
  Light light;
  light.kind = LightKind::kPoint, light.place = {16, 16, 16};
  request.shading.lights = {light};
  const Image image = draw(store, request);
  ASSERT_TRUE(showsSomething(image));
  for (const float number : image.rgba) ASSERT_TRUE(std::isfinite(number));
}

// A medium in a single headlight that scatters evenly has the colours of the function, whatever its gradients.
TEST(Scattering, InAHeadlight_isFlat) {
  const DenseVolume cloud = ball({{40, 40, 40}, VoxelType::u8}, {20, 20, 20}, 14, 200);
  const auto store = makeStore(cloud, "ball_fog", 32);
  FrameRequest request;
  request.view = resolve(cameraFrom(cloud.geometry, {0.4, -1, 0.3}, Projection::kPerspective), {64, 64});
  request.transfer_function = {1, {{0, {0.5, 0.7, 0.9}, 0}, {200, {1, 0.9, 0.8}, 0.2}}};
  request.transfer_function.scattering.emplace();
  const Image scattered = draw(store, request);
  request.transfer_function.scattering.reset();
  request.transfer_function.shaded = false;
  const Image flat = draw(store, request);
  EXPECT_LT(compareImages(scattered, flat).largest, 1e-5);
  request.transfer_function.shaded = true;
  EXPECT_GT(compareImages(draw(store, request), flat).largest, 0.02);
  request.shading.phong = false;
  EXPECT_TRUE(equalBits(draw(store, request), flat));
}

TEST(Scattering, OfACloud_isTheReference) {
  const DenseVolume cloud = fill({{48, 40, 44}, VoxelType::u8}, [](auto x, auto y, auto z) {
    const glm::dvec3 p(static_cast<double>(x) - 24, static_cast<double>(y) - 20, static_cast<double>(z) - 22);
    const double lumps = 3 * std::sin(0.5 * p.x) * std::cos(0.6 * p.y) * std::sin(0.4 * p.z + 1);
    return 30 * (16 + lumps - glm::length(p));
  });
  const auto store = makeStore(cloud, "cloud", 32);
  for (const bool perspective : {false, true}) {
    FrameRequest request;
    request.view = resolve(
        cameraFrom(cloud.geometry, {0.4, -1, 0.3}, perspective ? Projection::kPerspective : Projection::kOrthographic),
        {64, 64});
    request.level = 0;
    request.opacity_threshold = 0.9999;
    request.samples = 4;
    request.transfer_function = {1, {{0, glm::dvec3(1), 0}, {200, glm::dvec3(1), 0.25}}};
    request.transfer_function.scattering = {0.95, 0.4};
    request.shading.lights = {Light{LightKind::kDirectional, {-1, -0.4, 0.8}},
                              Light{LightKind::kPoint, {80, -40, 60}, {1, 0.6, 0.3}}};
    request.shading.shadows = true;
    const Image judged =
        referenceImage(cloud, request.view, request.transfer_function, request.shading, {}, {2, 0.5, 0.9999, true, {}});
    const double psnr = compareImages(judged, draw(store, request)).foreground_psnr_db;
    RecordProperty(perspective ? "perspective_psnr_db" : "parallel_psnr_db", std::to_string(psnr));
    EXPECT_GT(psnr, 36);
  }
}

}  // namespace
}  // namespace kiln::test
