// Pictures of iso-surfaces are equal to the bit for all bricks, visibility methods, tiles, threads, memory, crops and
// instruction sets: a crossing belongs to one cell of 8³ voxels, and positions on a ray do not depend on the cell.
#include <gtest/gtest.h>

#include "base/thread/parallel.h"
#include "support/reference/drawing.h"
#include "support/reference/scalar_kernels.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kSurfacesSize{107, 90};  // no multiple of a tile
constexpr int kSurfaceScenes = casesOf(6, 2);

// One to three surfaces.
TransferFunction randomSurfaces(Random& random, const ValueRange& range) {
  TransferFunction out;
  double value = range.lo;
  for (int left = random.between(1, 3); left > 0; --left) {
    value += random.uniform(0.1, 0.35) * (range.hi - range.lo);
    const glm::dvec3 color(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
    out.surfaces.push_back({value, color, random.chance(0.3) ? 1 : random.uniform(0.1, 0.9)});
  }
  return out;
}

FrameRequest randomRequest(std::uint64_t seed, const DenseVolume& volume) {
  Random random(seed ^ 0x69736f);
  FrameRequest out = requestOf(randomScene(seed, volume, kSurfacesSize), Lattice::kPixel, randomThreshold(seed));
  out.transfer_function = randomSurfaces(random, volume.range());
  if (seed % 2 == 0) out.aovs = {true, true};
  return out;
}

class SurfaceEquality : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (GetParam() == 0) volume_ = cheese({{45, 61, 50}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
    if (GetParam() == 1) volume_ = noise({{40, 51, 37}, VoxelType::u8, anisotropicAffine()}, 7, {0, 255});
    if (GetParam() == 2)
      volume_ = cheese({{40, 57, 35}, VoxelType::f32, obliqueAffine()}, 2, usualRange(VoxelType::f32));
  }
  DenseVolume volume_;
};

TEST_P(SurfaceEquality, HoldsForBricksMethodsThreadsTilesMemoryAndCrops) {
  std::vector<std::filesystem::path> stores;
  for (const std::int64_t size : {8, 16, 64}) stores.push_back(makeStore(volume_, "of_" + std::to_string(size), size));
  int with_something = 0;
  for (int i = 0; i < kSurfaceScenes; ++i) {
    const std::uint64_t seed = 50 + static_cast<std::uint64_t>(i);
    FrameRequest request = randomRequest(seed, volume_);
    request.level = 0;
    request.visibility.method = VisibilityMethod::kNone;
    const Image truth = draw(stores[2], request);
    with_something += showsSomething(truth) ? 1 : 0;
    for (const auto& store : stores) {
      for (const VisibilityMethod method : {VisibilityMethod::kMask, VisibilityMethod::kRangeTree}) {
        request.visibility.method = method;
        EXPECT_TRUE(equalBits(truth, draw(store, request))) << store << " seed " << seed;
      }
    }
    const ThreadLimit one(1);
    request.tile_px = 64 << seed % 3;
    EXPECT_TRUE(equalBits(truth, draw(stores[1], request, 1 << 22)))
        << "tiles of " << request.tile_px << ", seed " << seed;
    request.crop = PixelRect{13, 7, 75, 81};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), draw(stores[0], request))) << "crop, seed " << seed;
  }
  EXPECT_GT(with_something, kSurfaceScenes / 2);
}

TEST_P(SurfaceEquality, HoldsForInstructionSetsAndLevels) {
  const auto store = makeStore(volume_, "sets", 16);
  for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCatmullRom}) {
    for (const std::optional<int> level : {std::optional(0), std::optional(1), std::optional<int>()}) {
      FrameRequest request = randomRequest(60, volume_);
      request.clipping = {};
      request.view = resolve(cameraFrom(volume_.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSurfacesSize);
      request.interpolation = interpolation;
      request.level = level;
      const Image best = draw(store, request);
      EXPECT_TRUE(showsSomething(best));
      onEveryInstructionSet([&](std::int64_t target) {
        EXPECT_TRUE(equalBits(best, draw(store, request))) << "instruction set " << target;
      });
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Volumes, SurfaceEquality, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace kiln::test
