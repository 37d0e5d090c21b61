// Turning the camera by a tenth of a degree, or zooming by a hundredth, must change the picture as much as the
// reference's. A larger change is popping or crawling, a smaller change is blur. The arc of 20 degrees crosses a plane
// of the lattice, where the visiting order flips. Of the 200 steps a seeded few are drawn, always including the
// crossing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "frame/light/illuminate.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/quality_scenes.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

constexpr double kArcDeg = 20, kStepDeg = 0.1;

// About the vertical through the target.
Camera turned(Camera camera, double angle_deg) {
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), angle_deg * std::numbers::pi / 180, glm::normalize(camera.up));
  camera.eye = camera.target + glm::dvec3(turn * glm::dvec4(camera.eye - camera.target, 0));
  return camera;
}

// Returns the root mean square change of RGB over the pixels that are visible in either picture. unit: 1 / 255.
double change(const Image& a, const Image& b) {
  double squares = 0;
  int pixels = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    if (std::max(a.rgba[i + 3], b.rgba[i + 3]) <= 1.0f / 255) continue;
    for (std::size_t c = 0; c < 3; ++c) squares += std::pow(a.rgba[i + c] - b.rgba[i + c], 2.0);
    ++pixels;
  }
  return 255 * std::sqrt(squares / (3.0 * pixels));
}

// Towards the target, by a hundredth for each tenth of a degree.
Camera zoomed(Camera camera, double angle_deg) {
  camera.height *= std::pow(1.01, angle_deg / kStepDeg);
  camera.eye = camera.target + std::pow(1.01, angle_deg / kStepDeg) * (camera.eye - camera.target);
  return camera;
}

struct Turning {
  DenseVolume volume;
  fs::path store;
  Camera camera;  // in the middle of the arc
  TransferFunction transfer_function;
  ReferenceSettings reference;
  int pixels, steps;
  Camera (*moved)(Camera, double angle_deg) = turned;
};

// Ratio of the change of our picture to the change of the reference's picture.
struct Popping {
  double mean_ratio = 0, largest_ratio = 0;
};

Popping poppingOf(const Turning& turning, const FrameRequest& base, const char* name) {
  const StoreReader reader(turning.store);
  BrickCache cache(reader, 2ull << 30);
  const auto frames = [&](double angle_deg) {
    FrameRequest request = base;
    request.transfer_function = turning.transfer_function;
    request.opacity_threshold = 0.9999;
    request.view = resolve(turning.moved(turning.camera, angle_deg), {turning.pixels, turning.pixels});
    Progress silent;
    FrameStatistics statistics;
    return std::pair(renderFrame(cache, request, silent, statistics),
                     referenceImage(turning.volume, request.view, turning.transfer_function, request.shading,
                                    {0, 0, 0, 0}, turning.reference));
  };
  Popping out;
  double sum = 0, sum_reference = 0;
  for (int n = 0; n < turning.steps; ++n) {
    const double begin = n == 0 ? -kStepDeg / 2 : kArcDeg * (hashUnit(5, static_cast<std::uint64_t>(n)) - 0.5);
    const auto before = frames(begin), after = frames(begin + kStepDeg);
    const double ours = change(before.first, after.first), reference = change(before.second, after.second);
    sum += ours;
    sum_reference += reference;
    out.mean_ratio += ours / reference / turning.steps;
    out.largest_ratio = std::max(out.largest_ratio, ours / reference);
  }
  std::printf("%s: a step changes %.2f/255 rms, the reference's %.2f; ratio %.2f on average, %.2f at most\n", name,
              sum / turning.steps, sum_reference / turning.steps, out.mean_ratio, out.largest_ratio);
  return out;
}

// A small computed head, with skin in front of the camera.
Turning turningHead(Projection projection, const ReferenceSettings& reference, int pixels, int frames) {
  Turning out{head({{48, 48, 36}, VoxelType::i16}, usualRange(VoxelType::i16)), {}, {}, {}, reference, pixels, frames};
  out.store = makeStore(out.volume, "head", 32);
  out.camera = cameraFrom(out.volume.geometry, {0, -1, 0.2}, projection);
  const ValueRange range = out.volume.range();
  const glm::dvec3 color(0.93, 0.74, 0.6);
  out.transfer_function.points = {{range.lo + 0.15 * (range.hi - range.lo), color, 0},
                                  {range.lo + 0.3 * (range.hi - range.lo), color, 0.95}};
  return out;
}

class Turn : public ::testing::TestWithParam<std::tuple<Lattice, Projection>> {
 protected:
  // `of_rays`: upper bound for the mean ratio of a picture with a ray a pixel.
  void check(const Turning& turning, const std::string& scene, double of_rays, int samples = 1) {
    const auto [lattice, projection] = GetParam();
    FrameRequest request;
    setLattice(request, lattice);
    request.samples = samples;
    const std::string name = scene + ", " + nameOf(lattice) + " lattice, " + nameOf(projection);
    const Popping popping = poppingOf(turning, request, name.c_str());
    // Compositing splat by splat depends on the visiting order: the picture pops where the order flips.
    const double mean = lattice == Lattice::kVoxel ? 6 : of_rays;
    EXPECT_LT(popping.mean_ratio, mean) << name;
    EXPECT_LT(popping.largest_ratio, lattice == Lattice::kVoxel ? 25 : mean + 0.15) << name;
    EXPECT_GT(popping.mean_ratio, 0.7) << name;
  }
};

TEST_P(Turn, ChangesAsMuchAsItShould) {
  Turning turning = turningHead(std::get<1>(GetParam()), {3, 0.25, 0.9999}, 72, 8);
  check(turning, "procedural head", 1.15);
}

// The shadows of a standing light stay where they are on the head.
TEST_P(Turn, OfShadowsChangesAsMuchAsItShould) {
  const auto [lattice, projection] = GetParam();
  if (lattice == Lattice::kVoxel) return;
  Turning turning = turningHead(projection, {2, 0.5, 0.9999}, 72, 3);
  FrameRequest request;
  request.samples = 4;
  request.shading.shadows = true;
  Light standing;
  standing.kind = LightKind::kDirectional;
  standing.place = {-0.8, -1, 0.9};
  request.shading.lights = {standing};
  request.transfer_function = turning.transfer_function;
  request.view = resolve(turning.camera, {turning.pixels, turning.pixels});
  {
    const StoreReader reader(turning.store);
    BrickCache cache({&reader}, 1ull << 30, 0);
    FrameStatistics ignored;
    FrameRequest lit = request;
    Progress silent;
    illuminate(cache, silent, lit, ignored);
    turning.reference.shadow_start = lit.illumination->lights.front().start;
  }
  for (Camera (*moved)(Camera, double) : {turned, zoomed}) {
    turning.moved = moved;
    const std::string name = fmt::format("shadows, {}, {}", moved == turned ? "turntable" : "zoom", nameOf(projection));
    const Popping popping = poppingOf(turning, request, name.c_str());
    EXPECT_LT(popping.mean_ratio, 1.2) << name;
    EXPECT_GT(popping.mean_ratio, 0.7) << name;
  }
}

// Occlusion stays on the head: its grid depends on the volume alone.
TEST_P(Turn, OfOcclusionChangesAsMuchAsItShould) {
  const auto [lattice, projection] = GetParam();
  if (lattice == Lattice::kVoxel) return;
  Turning turning = turningHead(projection, {2, 0.5, 0.9999}, 56, 3);
  turning.reference.occlusion_rays = 32;
  turning.reference.equal_occlusion_rays = true;
  turning.reference.occlusion_start = turning.volume.geometry.meanSpacing();
  FrameRequest request;
  request.samples = 16;
  request.shading.ambient = request.shading.diffuse = 0.5;
  request.shading.occlusion = {1, 8 * turning.volume.geometry.meanSpacing(), true};
  const Popping popping = poppingOf(turning, request, fmt::format("occlusion, {}", nameOf(projection)).c_str());
  EXPECT_LT(popping.mean_ratio, 1.2);
  EXPECT_GT(popping.mean_ratio, 0.7);
}

TEST_P(Turn, NightlyOfARealHead) {
  QualityVolume subject = qualityVolumes().front();
  const fs::path input = fs::path(KILN_TEST_DATA_DIR) / subject.file;
  if (!fs::exists(input)) GTEST_SKIP() << input << " is not here";
  subject.from = {0, -1, -0.2};
  Turning turning{readVolume(input), {}, {}, {}, {4, 0.25, 0.9999}, 256, 20};
  turning.store = makeStore(turning.volume, "cthead", 128);
  for (const double px_per_voxel : {0.5, 1.0, 2.0, 4.0}) {
    for (const Material material : kMaterials) {
      turning.camera =
          cameraOf(subject, turning.volume.geometry, std::get<1>(GetParam()), px_per_voxel, turning.pixels);
      turning.transfer_function = transferFunctionOf(subject, material);
      // The default number of samples. In a scanned head at a pixel a voxel, a ray either meets or misses a detail.
      const bool rays = std::get<0>(GetParam()) == Lattice::kPixel;
      check(turning, fmt::format("cthead, {}, {} px/voxel", nameOf(material), px_per_voxel), 2.5,
            rays && px_per_voxel < 0.75 ? 4 : 1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lattices, Turn,
                         ::testing::Combine(::testing::ValuesIn(kLattices),
                                            ::testing::Values(Projection::kOrthographic, Projection::kPerspective)));

}  // namespace
}  // namespace kiln::test
