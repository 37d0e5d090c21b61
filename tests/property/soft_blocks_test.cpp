// Blocks of voxels that look nearly the same all over have fewer samples than others (SampleTable::soft). Which do is
// decided by voxels that every brick has that draws them, so that no picture depends on bricks, tiles or threads.
#include <gtest/gtest.h>

#include "base/parallel.h"
#include "support/drawing.h"
#include "support/procedural.h"
#include "support/test_store.h"

namespace kiln::test {
namespace {

// Tissue that is thin, and something in it that is not.
TransferFunction thinAndSteep() {
  return {1, {{20, {1, 0.6, 0.4}, 0}, {60, {1, 0.6, 0.4}, 0.05}, {215, {1, 0.7, 0.5}, 0.06}, {225, {1, 1, 0.9}, 0.9}}};
}

// The same, of which nothing is judged: gradients may take opacity away, but take none.
TransferFunction notJudged() {
  TransferFunction out = thinAndSteep();
  out.gradient_opacity = {{0, 1}, {1, 1}};
  return out;
}

class SoftBlocks : public ::testing::TestWithParam<std::tuple<Projection, Interpolation>> {};

TEST_P(SoftBlocks, AreThoseOfAnyBrick) {
  const auto [projection, interpolation] = GetParam();
  const DenseVolume volume = cheese({{37, 41, 30}, VoxelType::u8}, 3, {0, 255});
  std::vector<std::filesystem::path> stores;
  for (const std::int64_t brick : {8, 16, 32, 64})
    stores.push_back(makeStore(volume, "soft_" + std::to_string(brick), brick));
  int fewer = 0;
  for (const double px_per_voxel : {0.9, 1.27, 2.6}) {
    SCOPED_TRACE(px_per_voxel);
    FrameRequest request;
    request.level = 0;
    request.interpolation = interpolation;
    request.transfer_function = thinAndSteep();
    Camera camera = cameraFrom(volume.geometry, {0.5, -1, 0.35}, projection);
    camera.height = 60 / px_per_voxel;
    camera.fov_deg *= camera.height / 50;
    request.view = resolve(camera, {70, 62});
    request.aovs = {true, true};
    FrameStatistics statistics;
    const Image truth = draw(stores.back(), request, std::uint64_t{1} << 30, &statistics);
    for (const std::filesystem::path& store : stores) EXPECT_TRUE(equalBits(truth, draw(store, request))) << store;
    request.tile_px = 128;
    request.sweep_px = 16;
    const ThreadLimit one(1);
    EXPECT_TRUE(equalBits(truth, draw(stores.front(), request)));
    // Light goes through them as it does through others.
    FrameStatistics of_others;
    request.transfer_function = notJudged();
    const Image others = draw(stores.back(), request, std::uint64_t{1} << 30, &of_others);
    fewer += static_cast<double>(statistics.voxels_splats) < 0.8 * static_cast<double>(of_others.voxels_splats) ? 1 : 0;
  }
  EXPECT_GE(fewer, 2);
}

INSTANTIATE_TEST_SUITE_P(Views, SoftBlocks,
                         ::testing::Combine(::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                            ::testing::Values(Interpolation::kLinear, Interpolation::kCubic)));

}  // namespace
}  // namespace kiln::test
