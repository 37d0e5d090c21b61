// No seam between soft cells, which have fewer samples, and their neighbours. A plate has a constant extinction but two
// values, with a thin transparent layer of intermediate values between them. Cells at the layer are not soft, cells on
// both sides are. Away from the layer, alpha is the closed form, 1 - exp(-τ length).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr double kOpacity = 0.55;  // an optical depth of 0.8 a voxel; the layer changes the depth by twice as much
constexpr std::int64_t kAcross = 64, kThick = 8;
constexpr double kLayer = 32;  // begins half a voxel before

// The plate is 100 up to the layer and 200 from there on.
DenseVolume plate() {
  DenseVolume out = slab({{kAcross, kThick, kAcross}, VoxelType::u8}, 0, 0, 32, 100);
  for (std::byte& voxel : out.voxels) voxel = voxel == std::byte{0} ? std::byte{200} : voxel;
  return out;
}

TransferFunction twoPlateaus() {
  const glm::dvec3 white(1);
  return {1, {{0, white, kOpacity}, {140, white, kOpacity}, {145, white, 0}, {155, white, 0}, {160, white, kOpacity}}};
}

class SoftCells : public ::testing::TestWithParam<Projection> {};

TEST_P(SoftCells, MeetOthersWithoutASeam) {
  const DenseVolume volume = plate();
  const std::filesystem::path store = makeStore(volume, "plate", 32);
  const double tau = -std::log1p(-kOpacity);
  for (const double px_per_voxel : {0.9, 1.27, 1.6, 2.0, 2.9}) {
    SCOPED_TRACE(px_per_voxel);
    FrameRequest request;
    request.level = 0;
    request.transfer_function = twoPlateaus();
    request.shading.phong = false;
    request.opacity_threshold = 1;
    Camera camera = cameraFrom(volume.geometry, {0.31, -1, 0.22}, GetParam());
    const int pixels = static_cast<int>(90 * px_per_voxel);
    camera.height = 90;
    request.view = resolve(camera, {pixels, pixels});
    FrameStatistics statistics;
    const Image image = draw(store, request, std::uint64_t{1} << 30, &statistics);
    double worst = 0, sum = 0;
    int count = 0;
    for (int y = 0; y < pixels; ++y) {
      for (int x = 0; x < pixels; ++x) {
        const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
        const auto at = [&](double plane) {
          return ray.origin + (plane - ray.origin.y) / ray.direction.y * ray.direction;
        };
        const glm::dvec3 in = at(-0.5), out = at(kThick - 0.5);
        bool asked = true;
        for (const glm::dvec3& p : {in, out}) {
          for (const double edge : {p.x, p.z}) asked = asked && edge > 3 && edge < kAcross - 4;
          // A footprint and a voxel away from the layer.
          asked = asked && std::abs(p.x - (kLayer - 0.5)) > 1 + 2.5 / px_per_voxel;
        }
        if (!asked) continue;
        const double depth = tau * glm::length(out - in);
        const double error = -std::log1p(-static_cast<double>(image.pixel(x, y)[3])) / depth - 1;
        worst = std::max(worst, std::abs(error)), sum += error, ++count;
      }
    }
    ASSERT_GT(count, 1000);
    EXPECT_LT(worst, 0.03);
    EXPECT_LT(std::abs(sum / count), 0.0125);
    // A gradient opacity of 1 everywhere: no cell is tested for softness.
    request.transfer_function.gradient_opacity = {{0, 1}, {1, 1}};
    FrameStatistics of_others;
    draw(store, request, std::uint64_t{1} << 30, &of_others);
    const double part = static_cast<double>(statistics.voxels_splats) / static_cast<double>(of_others.voxels_splats);
    // Two slabs of half a pixel or more are a voxel, or less, from a pixel a voxel on.
    EXPECT_LT(part, px_per_voxel < 1 ? 1.001 : 0.75);
  }
}

INSTANTIATE_TEST_SUITE_P(Views, SoftCells, ::testing::Values(Projection::kOrthographic, Projection::kPerspective));

// Known because each ray's first sample lies within a voxel of the face, whose normal lights the sample, whatever the
// gradients of the noise behind the face.
class SoftCellsAtFaces : public ::testing::TestWithParam<double> {};

TEST_P(SoftCellsAtFaces, AreEvenlyLit) {
  const DenseVolume volume = fill({{40, 40, 40}}, [](auto x, auto y, auto z) {
    return 100 + 50 * hashUnit(1, static_cast<std::uint64_t>((z * 40 + y) * 40 + x));
  });
  FrameRequest request = answerRequest(volume.geometry, {-1, 0, 0}, Projection::kOrthographic, 96);
  request.level = 0;
  request.transfer_function = {1, {{50, glm::dvec3(1), 0}, {60, glm::dvec3(1), 0.99}}};
  request.shading.phong = true;
  request.clipping.planes = {{{1, 0, 0}, -GetParam()}};
  const Image drawn = draw(makeStore(volume, "noise", 32), request);
  float least = 2, most = 0;
  for (int y = 30; y < 66; ++y) {
    for (int x = 30; x < 66; ++x) {
      ASSERT_GT(drawn.pixel(x, y)[3], 0.95f);
      least = std::min(least, drawn.pixel(x, y)[0]);
      most = std::max(most, drawn.pixel(x, y)[0]);
    }
  }
  EXPECT_LT(most, 1.02f * least);
}

// The first is the volume's border.
INSTANTIATE_TEST_SUITE_P(Cuts, SoftCellsAtFaces, ::testing::Values(-1, 20, 20.25, 20.5, 20.75));

}  // namespace
}  // namespace kiln::test
