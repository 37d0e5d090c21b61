// Ranges of sub-bricks in the index decide which bricks are read, and change no bit of a picture. Known from a store
// without them (format 1), whose bricks are read if any of their voxels may be visible. Random scenes: mostly so near
// that levels mix, with either interpolation, clipped, cropped, by a single thread and by all.
#include <gtest/gtest.h>

#include "base/thread/parallel.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kSize{97, 83};

constexpr std::uint64_t kScenes = casesOf(16, 4);

FrameRequest sceneOf(std::uint64_t seed, const DenseVolume& volume) {
  const RandomScene scene = randomScene(seed, volume, kSize);
  FrameRequest request = requestOf(scene, Lattice::kPixel, randomThreshold(seed));
  if (seed % 4 != 0) {
    Camera camera = cameraFrom(volume.geometry, randomDirection(seed, 0), Projection::kPerspective);
    camera.eye = camera.target + 0.6 * (camera.eye - camera.target);
    camera.fov_deg = 100;
    request.view = resolve(camera, kSize);
  }
  if (seed % 5 == 1) request.level = 1;
  if (seed % 6 == 2) request.crop = PixelRect{20, 10, 70, 55};
  return request;
}

// Draws scenes from a store with sub-ranges and from a store without them: equal pictures, no more bricks read.
void check(std::uint64_t first_seed, std::uint64_t scenes, std::int64_t brick_size) {
  const DenseVolume volume = head({{120, 131, 60}, VoxelType::i16, anisotropicAffine()}, usualRange(VoxelType::i16));
  const auto with = makeStore(volume, "with", brick_size), without = makeStore(volume, "without", brick_size);
  makeFormat(1, without);
  std::uint64_t read_with = 0, read_without = 0;
  for (std::uint64_t seed = first_seed; seed < first_seed + scenes; ++seed) {
    const FrameRequest request = sceneOf(seed, volume);
    const ThreadLimit threads(seed % 2 == 0 ? 1 : 2);
    FrameStatistics few, many;
    const Image truth = draw(without, request, 1ull << 30, &many);
    EXPECT_TRUE(equalBits(truth, draw(with, request, 1ull << 30, &few))) << "seed " << seed;
    EXPECT_EQ(few.bricks_contributing, many.bricks_contributing) << "seed " << seed;
    // With read-ahead, threads may read bricks that become hidden.
    if (seed % 2 != 0) continue;
    EXPECT_LE(few.bricks_read, many.bricks_read) << "seed " << seed;
    read_with += few.bricks_read;
    read_without += many.bricks_read;
  }
  EXPECT_LT(read_with, read_without);
}

TEST(SubBricks, SaveReadingAndChangeNoPicture) { check(704, kScenes, 32); }
TEST(SubBricks, OfLargeBricksSaveReadingAndChangeNoPicture) { check(726, kScenes, 64); }
TEST(SubBricks, NightlySaveReadingAndChangeNoPicture) {
  check(7000, 100, 32);
  check(7100, 100, 64);
}

}  // namespace
}  // namespace kiln::test
