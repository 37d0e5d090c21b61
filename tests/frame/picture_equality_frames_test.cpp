// Options of the group "speed" change no bit of a picture or of its depth and normal planes, and the planes change no
// bit of the picture. The division into bricks changes no bit either, for three reasons:
// 1. Visiting order is decided per cell of 8³ voxels of a single octree.
// 2. A footprint's weights are normalized over the whole footprint.
// 3. Each pixel is written by a single tile.
// Pictures of a scene are therefore equal to the bit for every brick size, visibility method, thread count, tile size
// and memory budget. `--level auto` chooses the level per brick, so the picture also depends on the brick size, but on
// nothing else.
#include <gtest/gtest.h>

#include <span>

#include "base/thread/parallel.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kEqualSize = casesOf(ImageSize{150, 117}, ImageSize{97, 83});  // no multiple of a tile

// Sanitizers need minutes for a store of a thousand one-cell bricks; a hundred bricks exercise the code equally well.
constexpr std::int64_t kSmallestBrick = casesOf(8, 16);
constexpr int kQuickScenes = casesOf(3, 1);  // per lattice and volume; the nightly test has 400
constexpr ProjectedArea kEveryArea[] = {ProjectedArea::kBox, ProjectedArea::kSphere};
constexpr std::span kAreas(kEveryArea, casesOf(2, 1));

// Smallest size of a voxel for which a brick's apron holds every sample that its pixels need. For smaller voxels a
// frame takes a coarser level, if the store has a coarser level. unit: pixels.
constexpr double kLeastVoxel = 0.45;

// Magnifies the view until no voxel is smaller than `kLeastVoxel`.
void magnify(View& view, const VolumeGeometry& volume) {
  double depth = 0;
  for (const glm::dvec3& corner : volume.corners())
    depth = std::max(depth, (view.view_from_world * glm::dvec4(corner, 1)).z);
  const double edge = volume.shortestEdge();
  view.focal_px =
      std::max(view.focal_px, kLeastVoxel / edge * (view.projection == Projection::kPerspective ? depth : 1));
}

// Volumes that differ in type, proportions and affine; no extent is a multiple of a brick.
std::vector<DenseVolume> volumes() {
  std::vector<DenseVolume> out;
  out.push_back(cheese({{75, 61, 90}, VoxelType::i16}, 1, usualRange(VoxelType::i16)));
  out.push_back(head({{70, 81, 47}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8)));
  out.push_back(cheese({{40, 97, 55}, VoxelType::f32, obliqueAffine()}, 2, usualRange(VoxelType::f32)));
  return out;
}

// With memory for a single brick, each brick is still read only once.
void checkLeastMemory(const std::filesystem::path& store, const FrameRequest& request, const Image& truth,
                      std::uint64_t seed) {
  const StoreReader reader(store);
  std::uint64_t smallest = 0;
  for (int level = 0; level < reader.index().levels(); ++level) {
    const Extent3& n = reader.index().lattice(level);
    for (std::int64_t b = 0; b < n.count(); ++b)
      smallest = std::max<std::uint64_t>(smallest, reader.readBytes({level, brickAt(n, b)}));
  }
  FrameStatistics statistics;
  EXPECT_TRUE(equalBits(truth, draw(store, request, smallest, &statistics))) << "least memory, seed " << seed;
  EXPECT_LE(statistics.bricks_read, statistics.bricks_interesting) << "a brick was read twice, seed " << seed;
}

class PictureEquality : public ::testing::TestWithParam<std::tuple<int, Lattice>> {
 protected:
  // Opens a store for each brick size: 8 is a single cell, 128 is the whole volume in a single brick.
  void SetUp() override {
    volume_ = std::move(volumes()[static_cast<std::size_t>(std::get<0>(GetParam()))]);
    for (const std::int64_t size : {kSmallestBrick, std::int64_t{32}, std::int64_t{64}, std::int64_t{128}}) {
      stores_.push_back(makeStore(volume_, "bricks_of_" + std::to_string(size), size));
    }
  }

  void check(std::uint64_t first_seed, int scenes) {
    int pictures_with_something = 0;
    for (int i = 0; i < scenes; ++i) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
      const RandomScene scene = randomScene(seed, volume_, kEqualSize);
      const double threshold = randomThreshold(seed);
      FrameRequest request = requestOf(scene, std::get<1>(GetParam()), threshold);
      request.level = 0;
      if (request.lattice == Lattice::kPixel) magnify(request.view, volume_.geometry);
      request.visibility.method = VisibilityMethod::kNone;
      if (seed % 4 == 0) request.aovs = {true, true};
      const Image truth = draw(stores_[3], request);
      for (std::size_t at = 3; at < truth.rgba.size(); at += 4) {
        if (truth.rgba[at] > 0) {
          ++pictures_with_something;
          break;
        }
      }
      checkExactMethods(request, truth, seed);
      for (const auto& store : stores_)
        EXPECT_TRUE(equalBits(truth, draw(store, request))) << store << " seed " << seed;
      const ThreadLimit one(1);
      request.tile_px = 64 << seed % 3;
      EXPECT_TRUE(equalBits(truth, draw(stores_[1], request)))
          << "one thread, tiles of " << request.tile_px << ", seed " << seed;
      checkLeastMemory(stores_[1], request, truth, seed);
      request.aovs = {};
      EXPECT_TRUE(equalBits(colorsOf(truth), draw(stores_[2], request))) << "without planes, seed " << seed;
    }
    EXPECT_GT(pictures_with_something, scenes / 2);
  }

  // Each exact method, with either projected area, in tiles by all threads and with the frame as a single tile.
  void checkExactMethods(FrameRequest request, const Image& truth, std::uint64_t seed) {
    for (const VisibilityMethod method :
         {VisibilityMethod::kMask, VisibilityMethod::kRangeTree, VisibilityMethod::kOverlay}) {
      for (const ProjectedArea area : kAreas) {
        request.visibility = {method, area};
        request.visibility.test_samples = seed % 2 == 0;
        request.tile_px = (static_cast<int>(method) + static_cast<int>(area) + seed) % 2 == 0 ? 64 : 0;
        EXPECT_TRUE(equalBits(truth, draw(stores_[2], request)))
            << "method " << static_cast<int>(method) << " area " << static_cast<int>(area) << " tiles of "
            << request.tile_px << ", seed " << seed;
      }
    }
  }

  DenseVolume volume_;
  std::vector<std::filesystem::path> stores_;
};

TEST_P(PictureEquality, HoldsForBricksMethodsThreadsTilesAndMemory) { check(100, kQuickScenes); }
TEST_P(PictureEquality, NightlyHoldsForManyScenes) { check(1000, 400); }

INSTANTIATE_TEST_SUITE_P(Volumes, PictureEquality,
                         ::testing::Combine(::testing::Values(0, 1, 2), ::testing::ValuesIn(kLattices)));

// Checks `--level auto` from a view so near that several levels are drawn.
class MixedLevels : public ::testing::TestWithParam<std::tuple<int, Lattice>> {
 protected:
  void check(std::uint64_t first_seed, int scenes) {
    const DenseVolume volume = std::move(volumes()[static_cast<std::size_t>(std::get<0>(GetParam()))]);
    const auto store = makeStore(volume, "pyramid", 16);
    int mixed = 0;
    for (int i = 0; i < scenes; ++i) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
      FrameRequest request =
          requestOf(randomScene(seed, volume, kEqualSize), std::get<1>(GetParam()), randomThreshold(seed));
      Camera camera = cameraFrom(volume.geometry, randomDirection(seed, 0), Projection::kPerspective);
      camera.eye = camera.target + 0.5 * (camera.eye - camera.target);
      camera.fov_deg = 110;
      request.view = resolve(camera, kEqualSize);
      request.visibility.method = VisibilityMethod::kNone;
      request.aovs = {true, true};
      FrameStatistics statistics;
      const Image truth = draw(store, request, 1ull << 30, &statistics);
      mixed += statistics.levels[0].bricks > 0 && statistics.levels[1].bricks > 0 ? 1 : 0;
      for (const VisibilityMethod method : {VisibilityMethod::kMask, VisibilityMethod::kRangeTree}) {
        request.visibility = {method, kAreas[seed % kAreas.size()]};
        request.tile_px = (static_cast<int>(method) + seed) % 2 == 0 ? 64 : 0;
        EXPECT_TRUE(equalBits(truth, draw(store, request)))
            << "method " << static_cast<int>(method) << ", seed " << seed;
      }
      const ThreadLimit one(1);
      request.tile_px = 128;
      checkLeastMemory(store, request, truth, seed);
    }
    EXPECT_GT(mixed, scenes / 10);
  }
};

TEST_P(MixedLevels, HoldForMethodsThreadsTilesAndMemory) { check(213, (kQuickScenes + 1) / 2); }
TEST_P(MixedLevels, NightlyHoldForManyScenes) { check(2000, 100); }

INSTANTIATE_TEST_SUITE_P(Volumes, MixedLevels,
                         ::testing::Combine(::testing::Values(0, 1, 2), ::testing::ValuesIn(kLattices)));

}  // namespace
}  // namespace kiln::test
