// Pictures of iso-surfaces are equal to the bit for all bricks, visibility methods, tiles, threads, memory, crops and
// instruction sets: a crossing belongs to one cell of 8³ voxels, and positions on a ray do not depend on the cell.
#include <gtest/gtest.h>

#include <string>

#include "support/reference/drawing.h"
#include "support/reference/drawn_alike.h"
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
  const DenseVolume volume_ = drawnAlikeVolume(GetParam());
};

TEST_P(SurfaceEquality, HoldsForBricksMethodsThreadsTilesMemoryAndCrops) {
  const std::vector<std::filesystem::path> stores = storesOfThreeBricks(volume_);
  int with_something = 0;
  for (int i = 0; i < kSurfaceScenes; ++i) {
    const std::uint64_t seed = 50 + static_cast<std::uint64_t>(i);
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Image truth = expectDrawnAlike(stores, randomRequest(seed, volume_), seed);
    with_something += showsSomething(truth) ? 1 : 0;
  }
  EXPECT_GT(with_something, kSurfaceScenes / 2);
}

TEST_P(SurfaceEquality, HoldsForInstructionSetsAndLevels) {
  FrameRequest request = randomRequest(60, volume_);
  request.clipping = {};
  request.view = resolve(cameraFrom(volume_.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSurfacesSize);
  expectAlikeOnInstructionSets(makeStore(volume_, "sets", 16), request);
}

INSTANTIATE_TEST_SUITE_P(Volumes, SurfaceEquality, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace kiln::test
