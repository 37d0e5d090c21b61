// Several volumes in a picture. Every brick adds its samples to slabs shared by all volumes, volume by volume; a pixel
// has one sample of each volume in a slab. Pictures are therefore equal to the bit for every brick size of either
// volume, thread count, tile, budget, visibility method and crop.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "base/thread/parallel.h"
#include "frame/pass/frame_drawing.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/system/expect_error.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

using Paths = std::vector<std::filesystem::path>;
constexpr ImageSize kMixSize{150, 117};

constexpr int kMixScenes = casesOf(6, 1);

// Two overlapping volumes of different spacing, rotation and type.
std::vector<DenseVolume> mixedVolumes() {
  std::vector<DenseVolume> out;
  out.push_back(cheese({{75, 61, 90}, VoxelType::i16}, 1, usualRange(VoxelType::i16)));
  const glm::dmat4 turned = turnedAffine(0.6, {1.3, 0.9, 1.7}, {20, -10, 25});
  out.push_back(head({{50, 71, 37}, VoxelType::u8, turned}, usualRange(VoxelType::u8)));
  return out;
}

FrameRequest requestAt(std::uint64_t seed, const std::vector<DenseVolume>& volumes) {
  const RandomScene scene = randomScene(seed, volumes[0], kMixSize);
  FrameRequest out = requestOf(scene, Lattice::kPixel, randomThreshold(seed));
  out.volumes.push_back({scene.transfer_function, scene.shading, scene.clipping});
  Random random(seed + 77);
  const DenseVolume& second = volumes[1];
  const TransferFunction function = randomTransferFunction(random, second.range(), second.geometry.meanSpacing());
  out.volumes.push_back({function, randomShading(random), randomClipping(random, second.geometry)});
  out.clipping = {};
  out.visibility.method = VisibilityMethod::kNone;
  if (seed % 3 == 0) out.aovs = {true, true};
  return out;
}

std::uint64_t leastBytes(const Paths& stores, const FrameRequest& request) {
  const StoreReader first(stores[0]), second(stores[1]);
  return std::max({bytesAtOnce({&first, &second}, request), first.largestReadBytes(), second.largestReadBytes()});
}

class VolumeMixEquality : public ::testing::Test {
 protected:
  void SetUp() override {
    volumes_ = mixedVolumes();
    for (const std::int64_t size : {16, 32, 128}) {
      for (std::size_t v = 0; v < volumes_.size(); ++v)
        stores_[v].push_back(makeStore(volumes_[v], "v" + std::to_string(v) + "_of_" + std::to_string(size), size));
    }
  }
  // Returns stores by index into the brick sizes above.
  Paths stores(std::size_t first, std::size_t second) const { return {stores_[0][first], stores_[1][second]}; }

  void check(std::uint64_t first_seed, int scenes) {
    int shown = 0;
    for (int i = 0; i < scenes; ++i) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
      SCOPED_TRACE("seed " + std::to_string(seed));
      FrameRequest request = requestAt(seed, volumes_);
      request.level = 0;  // smaller bricks have more levels
      if (i % 2 == 1) request.samples = 2;
      const Image truth = draw(stores(2, 2), request);
      shown += showsSomething(truth) ? 1 : 0;
      EXPECT_TRUE(equalBits(truth, draw(stores(0, 1), request))) << "bricks of 16 and 32";
      EXPECT_TRUE(equalBits(truth, draw(stores(1, 0), request))) << "bricks of 32 and 16";
      request.visibility.method = seed % 2 == 0 ? VisibilityMethod::kMask : VisibilityMethod::kRangeTree;
      EXPECT_TRUE(equalBits(truth, draw(stores(1, 1), request))) << "tested for visibility";
      checkLeastMemory(request, truth);
      request.crop = PixelRect{37, 21, 119, 90};
      EXPECT_TRUE(equalBits(partOf(truth, *request.crop), draw(stores(1, 1), request))) << "cropped";
    }
    EXPECT_GT(shown, scenes / 2);
  }

  void checkLeastMemory(FrameRequest request, const Image& truth) {
    const ThreadLimit one(1);
    const std::uint64_t least = leastBytes(stores(0, 0), request);
    EXPECT_TRUE(equalBits(truth, draw(stores(0, 0), request, least))) << "least memory";
    request.tile_px = 128;
    EXPECT_TRUE(equalBits(truth, draw(stores(0, 0), request))) << "tiles of 128";
    request.tile_px = 0;
    EXPECT_TRUE(equalBits(truth, draw(stores(0, 0), request))) << "one tile";
  }

  std::vector<DenseVolume> volumes_;
  Paths stores_[2];
};

TEST_F(VolumeMixEquality, HoldsForBricksThreadsTilesMemoryAndCrops) { check(500, kMixScenes); }
// Equality with automatic levels, from a view so near that levels change along the rays.
TEST_F(VolumeMixEquality, HoldsWhereLevelsMix) {
  for (const std::uint64_t seed : {600, 601}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = requestAt(seed, volumes_);
    Camera camera = cameraFrom(volumes_[0].geometry, randomDirection(seed, 0), Projection::kPerspective);
    camera.eye = camera.target + 0.5 * (camera.eye - camera.target);
    camera.fov_deg = 110;
    request.view = resolve(camera, kMixSize);
    FrameStatistics statistics;
    const Image truth = draw(stores(0, 0), request, 1ull << 30, &statistics);
    EXPECT_GT(statistics.levels[0].voxels_visited, 0u);
    EXPECT_GT(statistics.levels[1].voxels_visited, 0u);
    request.visibility.method = VisibilityMethod::kMask;
    checkLeastMemory(request, truth);
    request.crop = PixelRect{37, 21, 119, 90};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), draw(stores(0, 0), request))) << "cropped";
  }
}

TEST_F(VolumeMixEquality, NightlyHoldsForManyScenes) { check(5000, 200); }

// A budget smaller than the bricks of a tile fails; the error names the memory that works.
TEST_F(VolumeMixEquality, TooLittleMemoryIsRefused) {
  FrameRequest request = requestAt(502, volumes_);
  TransferFunction all{0, {{-1e9, glm::dvec3(1), 0.1}}};
  for (VolumeRequest& volume : request.volumes) volume = {all, {}, {}};
  const std::uint64_t least = leastBytes(stores(1, 1), request);
  EXPECT_NO_THROW(draw(stores(1, 1), request, least));
  expectError([&] { draw(stores(1, 1), request, least / 2); }, ErrorCode::kBudget, "give ");
}

// A part of the budget is set aside by the caller. Known: the picture keeps to the rest, and leaves the part as it was,
// also after an error.
TEST_F(VolumeMixEquality, PartsSetAsideAreKept) {
  FrameRequest request = requestAt(502, volumes_);
  TransferFunction all{0, {{-1e9, glm::dvec3(1), 0.1}}};
  for (VolumeRequest& volume : request.volumes) volume = {all, {}, {}};
  const StoreReader first(stores_[0][1]), second(stores_[1][1]);
  const std::uint64_t least = leastBytes(stores(1, 1), request);
  const Image truth = draw(stores(1, 1), request);
  BrickCache cache({&first, &second}, 2 * least);
  BrickCache::Aside aside(cache, least);
  Progress silent;
  FrameStatistics statistics;
  EXPECT_TRUE(equalBits(truth, renderFrame(cache, request, silent, statistics)));
  EXPECT_EQ(cache.bricksBytes(), least);
  aside.resize(least + least / 2);
  expectError([&] { renderFrame(cache, request, silent, statistics); }, ErrorCode::kBudget, "give ");
  EXPECT_EQ(cache.bricksBytes(), least - least / 2);
  // The frame ends between bricks, while their lists of cells are set aside.
  struct Stop : Progress {
    bool cancelled() const override { return ++looks > 3; }
    mutable std::atomic<int> looks = 0;
  } stop;
  aside.resize(least);
  expectError([&] { renderFrame(cache, request, stop, statistics); }, ErrorCode::kCancelled, "");
  EXPECT_EQ(cache.bricksBytes(), least);
}

// The second volume is transparent: it adds no sample and hides none.
TEST_F(VolumeMixEquality, ATransparentVolumeIsNoMatterOfOrder) {
  FrameRequest request = requestAt(504, volumes_);
  TransferFunction all{0, {{-1e9, glm::dvec3(1, 0.5, 0.2), 0.1}}}, nothing{0, {{0, glm::dvec3(1), 0}}};
  request.volumes = {{all, {}, {}}, {nothing, {}, {}}};
  const Image image = draw(stores(1, 1), request);
  std::swap(request.volumes[0], request.volumes[1]);
  EXPECT_TRUE(showsSomething(image));
  EXPECT_TRUE(equalBits(image, draw({stores_[1][1], stores_[0][1]}, request)));
}

// Two faint balls, each in eight bricks that hold an octant: each brick changes pixels.
TEST(SeveralVolumesStatistics, BricksThatChangePixels_areCounted) {
  const DenseVolume volume = ball({{32, 32, 32}, VoxelType::u8}, {15.5, 15.5, 15.5}, 12, 200);
  const std::filesystem::path path = makeStore(volume, "octants", 16);
  FrameRequest request = answerRequest(volume.geometry, {0.3, -1, 0.4}, Projection::kPerspective, 64);
  const TransferFunction faint{1, {{100, glm::dvec3(1), 0}, {180, glm::dvec3(1), 0.01}}};
  request.volumes = {{faint, {}, {}}, {faint, {}, {}}};
  FrameStatistics statistics;
  draw(Paths{path, path}, request, 1ull << 30, &statistics);
  const StoreReader store(path);
  std::uint64_t bytes = 0;
  for (std::int64_t i = 0; i < 8; ++i) bytes += store.index().at({0, brickAt(store.index().lattice(0), i)}).file_bytes;
  EXPECT_EQ(statistics.bricks_contributing, 16u);
  EXPECT_EQ(statistics.bricks_contributing_bytes, 2 * bytes);
}

}  // namespace
}  // namespace kiln::test
