// Soft cells, whose values look nearly equal, have one sample for two slabs (`inPairs`). Softness depends only on
// voxels contained in every brick that draws the cell. No picture therefore depends on bricks, tiles or threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "base/thread/parallel.h"
#include "grid/coords.h"
#include "image/compare.h"
#include "store/ranges/minmax_octree.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Sanitizers need a minute for a store of a hundred one-cell bricks.
constexpr std::int64_t kEveryBrick[] = {casesOf(8, 16), 64, 32};
constexpr std::span kBricks(kEveryBrick, casesOf(3, 2));

constexpr float kNan = NAN;

// Thin tissue with a dense body inside.
TransferFunction thinAndSteep() {
  return {1, {{20, {1, 0.6, 0.4}, 0}, {60, {1, 0.6, 0.4}, 0.04}, {215, {1, 0.7, 0.5}, 0.048}, {225, {1, 1, 0.9}, 0.9}}};
}

// Returns `thinAndSteep` without soft cells: a gradient opacity of 1 everywhere prevents the test.
TransferFunction notJudged() {
  TransferFunction out = thinAndSteep();
  out.gradient_opacity = {{0, 1}, {1, 1}};
  return out;
}

// Cells at the border, which are lit as a face, merge nothing, and are empty. Some voxels of type f32 are NaN.
DenseVolume volumeOf(VoxelType type) {
  constexpr std::int64_t kMargin = kCellSize + 1;
  const DenseVolume inside = cheese({{37, 41, 30}, type}, 3, {0, 255});
  DenseVolume out = fill({{55, 59, 48}, type}, [&](auto x, auto y, auto z) {
    const VoxelCoord at = {x - kMargin, y - kMargin, z - kMargin};
    return boxOf(inside.geometry.dims).contains(at) ? inside.valueAt(at.x, at.y, at.z) : 0.0;
  });
  if (type != VoxelType::f32) return out;
  for (std::size_t i = 0; i < out.voxels.size() / sizeof(float); ++i) {
    if (hashUnit(4, i) < 0.0002) std::memcpy(&out.voxels[i * sizeof(float)], &kNan, sizeof(float));
  }
  return out;
}

class SoftCells : public ::testing::TestWithParam<std::tuple<Projection, VoxelType>> {};

TEST_P(SoftCells, AreThoseOfAnyBrick) {
  const auto [projection, type] = GetParam();
  const DenseVolume volume = volumeOf(type);
  std::vector<std::filesystem::path> stores;
  for (const std::int64_t brick : kBricks) stores.push_back(makeStore(volume, "soft_" + std::to_string(brick), brick));
  for (const double px_per_voxel : {0.9, 1.27, 3.6}) {
    if (kSanitized && px_per_voxel != (projection == Projection::kOrthographic ? 0.9 : 3.6)) continue;
    SCOPED_TRACE(px_per_voxel);
    FrameRequest request;
    request.level = 0;
    request.transfer_function = thinAndSteep();
    Camera camera = cameraFrom(volume.geometry, {0.5, -1, 0.35}, projection);
    camera.height = 48 / px_per_voxel;
    camera.fov_deg *= camera.height / 70;
    request.view = resolve(camera, {56, 50});
    request.aovs = {true, true};
    if (type == VoxelType::f32) {
      request.interpolation = Interpolation::kCubic;
      request.clipping.planes = {{{1, 0.3, 0.2}, -27.7}};
    }
    FrameStatistics statistics;
    const Image truth = draw(stores.back(), request, std::uint64_t{1} << 30, &statistics);
    for (const std::filesystem::path& store : stores) EXPECT_TRUE(equalBits(truth, draw(store, request))) << store;
    request.tile_px = 128;
    {
      const ThreadLimit one(1);
      EXPECT_TRUE(equalBits(truth, draw(stores.front(), request)));
    }
    // Merged samples show nearly the picture of all samples.
    FrameStatistics of_others;
    request.transfer_function = notJudged();
    const Image others = draw(stores.back(), request, std::uint64_t{1} << 30, &of_others);
    const ImageDifference difference = compareImages(colorsOf(others), colorsOf(truth));
    EXPECT_GE(difference.foreground_psnr_db, 36);
    EXPECT_NEAR(difference.mean_brightness_ratio, 1, 0.01);
    // Two slabs of half a pixel or more are a voxel, or less, from a pixel a voxel on.
    const double part = static_cast<double>(statistics.voxels_splats) / static_cast<double>(of_others.voxels_splats);
    EXPECT_LT(part, px_per_voxel > 1 ? 0.96 : 1.001);
  }
}

INSTANTIATE_TEST_SUITE_P(Views, SoftCells,
                         ::testing::Combine(::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                            ::testing::Values(VoxelType::u8, VoxelType::f32)));

// Known because the sheet is even: neighbouring rays pass through equally much of it, and two samples half a voxel
// apart lie within it wherever a ray's samples begin.
TEST(SoftCellsOfSheet, HaveNoStripes) {
  const DenseVolume volume =
      fill({{40, 40, 40}}, [](auto x, auto, auto) { return static_cast<std::int64_t>(x) == 20 ? 100 : 0; });
  FrameRequest request = answerRequest(volume.geometry, {-1, -0.6, 0}, Projection::kOrthographic, 120);
  request.level = 0;
  request.transfer_function = {1, {{50, glm::dvec3(1), 0}, {100, glm::dvec3(1), 0.2}}};
  const Image drawn = draw(makeStore(volume, "sheet", 32), request);
  float least = 1, most = 0;
  for (int y = 50; y < 70; ++y) {
    for (int x = 50; x < 70; ++x) {
      least = std::min(least, drawn.pixel(x, y)[3]);
      most = std::max(most, drawn.pixel(x, y)[3]);
    }
  }
  EXPECT_GT(least, 0.05f);
  EXPECT_LT(most, 1.3f * least);
}

}  // namespace
}  // namespace kiln::test
