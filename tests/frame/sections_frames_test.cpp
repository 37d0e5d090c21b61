// Pictures of cut faces that show values are equal to the bit for all bricks, visibility methods, tiles, threads,
// memory, crops and instruction sets: a point on a face belongs to one cell, and its depth follows from the view alone.
#include <gtest/gtest.h>

#include "base/thread/parallel.h"
#include "support/reference/drawing.h"
#include "support/reference/drawn_alike.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kSectionsSize{107, 90};  // no multiple of a tile
constexpr int kSectionScenes = casesOf(8, 2);

Section randomSection(Random& random, const ValueRange& range) {
  Section out;
  out.opacity = random.chance(0.7) ? 1 : random.uniform(0.2, 0.9);
  if (random.chance(0.4)) return out;
  out.color_map = random.chance(0.5) ? "gray" : "viridis";
  out.window = glm::dvec2{random.uniform(range.lo, range.hi), random.uniform(0.2, 1) * (range.hi - range.lo)};
  return out;
}

// One to three planes near the middle.
Clipping randomCuts(Random& random, const VolumeGeometry& volume) {
  Clipping out;
  const glm::dvec3 middle(0.5 * static_cast<double>(volume.dims.x), 0.5 * static_cast<double>(volume.dims.y),
                          0.5 * static_cast<double>(volume.dims.z));
  for (int left = random.between(1, 3); left > 0; --left) {
    const glm::dvec3 through = volume.worldOf(middle + 6.0 * random.direction()), normal = random.direction();
    out.planes.push_back({normal, -glm::dot(normal, through)});
  }
  if (random.chance(0.3)) out.region = VoxelBox{{5, 6, 7}, {volume.dims.x - 4, volume.dims.y - 7, volume.dims.z - 3}};
  return out;
}

FrameRequest randomRequestOfSection(std::uint64_t seed, const DenseVolume& volume) {
  Random random(seed ^ 0x736563);
  FrameRequest out = requestOf(randomScene(seed, volume, kSectionsSize), Lattice::kPixel, randomThreshold(seed));
  out.clipping = randomCuts(random, volume.geometry);
  out.clipping.section = randomSection(random, volume.range());
  if (seed % 2 == 0) out.aovs = {true, true};
  if (seed % 3 == 0) out.samples = 2;
  return out;
}

class SectionEquality : public ::testing::TestWithParam<int> {
 protected:
  const DenseVolume volume_ = drawnAlikeVolume(GetParam());
};

TEST_P(SectionEquality, HoldsForBricksMethodsThreadsTilesMemoryAndCrops) {
  const std::vector<std::filesystem::path> stores = storesOfThreeBricks(volume_);
  int with_faces = 0;
  for (int i = 0; i < kSectionScenes; ++i) {
    const std::uint64_t seed = 150 + static_cast<std::uint64_t>(i);
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = randomRequestOfSection(seed, volume_);
    const Image truth = expectDrawnAlike(stores, request, seed);
    request.level = 0;
    request.visibility.method = VisibilityMethod::kNone;
    request.clipping.section.reset();
    with_faces += equalBits(truth, draw(stores[2], request)) ? 0 : 1;
  }
  EXPECT_GT(with_faces, kSectionScenes / 3);
}

TEST_P(SectionEquality, HoldsForInstructionSetsAndLevels) {
  FrameRequest request = randomRequestOfSection(160, volume_);
  request.view = resolve(cameraFrom(volume_.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSectionsSize);
  expectAlikeOnInstructionSets(makeStore(volume_, "sets", 16), request);
}

// Two volumes, each with a section of its own, in bricks of several sizes.
TEST_P(SectionEquality, HoldsForSeveralVolumes) {
  const DenseVolume other = cheese({{33, 30, 41}, VoxelType::u8, volume_.geometry.world_from_index}, 4, {0, 255});
  const std::vector<std::filesystem::path> large = {makeStore(volume_, "large", 64),
                                                    makeStore(other, "other_large", 32)};
  const std::vector<std::filesystem::path> small = {makeStore(volume_, "small", 16),
                                                    makeStore(other, "other_small", 8)};
  for (std::uint64_t seed = 170; seed < casesOf(174u, 171u); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    FrameRequest request = randomRequestOfSection(seed, volume_);
    request.level = 0;
    VolumeRequest first{request.transfer_function, request.shading, request.clipping};
    VolumeRequest second{randomTransferFunction(random, {0, 255}, 1), request.shading, request.clipping};
    second.clipping.section = randomSection(random, {0, 255});
    request.volumes = {first, second};
    const Image truth = draw(large, request);
    EXPECT_TRUE(equalBits(truth, draw(small, request)));
    request.visibility.method = VisibilityMethod::kRangeTree;
    const ThreadLimit one(1);
    request.tile_px = 128;
    EXPECT_TRUE(equalBits(truth, draw(small, request))) << "tiles of 128";
    request.crop = PixelRect{13, 7, 75, 81};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), draw(large, request))) << "crop";
  }
}

// A face through levels of the pyramid has no holes: the volume fills the picture.
TEST_P(SectionEquality, LeavesNoHolesBetweenLevels) {
  const auto store = makeStore(volume_, "levels", 8);
  FrameRequest request = randomRequestOfSection(180, volume_);
  const VolumeGeometry& geometry = volume_.geometry;
  const glm::dvec3 middle = geometry.worldOf(0.5 * glm::dvec3(geometry.dims.x, geometry.dims.y, geometry.dims.z) - 0.5);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(geometry.world_from_index[0]));
  Camera camera = cameraFrom(geometry, -normal, Projection::kPerspective);
  camera.eye = middle - 2.5 * geometry.spacing().x * normal;
  camera.target = middle + 0.4 * glm::cross(normal, glm::dvec3(0.3, 0.2, 1)) + normal;
  camera.fov_deg = 120;
  request.view = resolve(camera, kSectionsSize);
  request.clipping = {};
  request.clipping.planes = {{normal, -glm::dot(normal, middle)}};
  request.clipping.section = Section{"gray", glm::dvec2{0, 1e6}};
  request.level.reset();
  request.samples = 1;
  request.filters_rays = false;
  request.background = {};
  const Image image = draw(store, request);
  const int y = image.height / 2, x = image.width / 2;
  int seen = 0;
  for (int dy = -20; dy <= 20; ++dy) {
    for (int dx = -20; dx <= 20; ++dx) {
      ++seen;
      EXPECT_EQ(image.pixel(x + dx, y + dy)[3], 1) << dx << " " << dy;
    }
  }
  EXPECT_EQ(seen, 41 * 41);
}

INSTANTIATE_TEST_SUITE_P(Volumes, SectionEquality, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace kiln::test
