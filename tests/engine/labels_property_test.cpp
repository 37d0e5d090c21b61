// Pictures of label volumes are equal to the bit for all ways of drawing, and skipped parts are empty.
#include <gtest/gtest.h>

#include "base/thread/parallel.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kLabelsSize{80, 66};

// Nested bodies of six labels, 40 numbers apart: many ranges hold labels that no voxel has.
DenseVolume labelBodies() {
  DenseVolume out = cheese({{44, 39, 37}, VoxelType::u8, anisotropicAffine()}, 3, {0, 5});
  for (std::byte& voxel : out.voxels) voxel = static_cast<std::byte>(40 * static_cast<int>(voxel));
  return out;
}

// Shows a random subset of the labels, some of them translucent.
TransferFunction randomLabels(Random& random) {
  TransferFunction out;
  for (int label = 40; label <= 200; label += 40) {
    const glm::dvec3 color(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
    if (random.chance(0.6)) out.labels.push_back({static_cast<double>(label), "", color, random.uniform(0.05, 1)});
  }
  if (out.labels.empty()) out.labels.push_back({120, "", glm::dvec3(1), 0.7});
  return out;
}

FrameRequest labelRequest(std::uint64_t seed, const DenseVolume& volume, Lattice lattice) {
  RandomScene scene = randomScene(seed, volume, kLabelsSize);
  Random random(seed + 5);
  scene.transfer_function = randomLabels(random);
  FrameRequest out = requestOf(scene, lattice, randomThreshold(seed));
  // Two or three pixels a voxel, so that labels meet between voxels.
  const Projection projection = seed % 3 == 0 ? Projection::kOrthographic : Projection::kPerspective;
  out.view = resolve(cameraFrom(volume.geometry, randomDirection(seed, 0), projection), kLabelsSize);
  out.level = 0;  // smaller bricks have more levels
  if (seed % 2 == 0) out.aovs = {true, true};
  if (seed % 3 == 1 && lattice != Lattice::kVoxel) out.interpolation = Interpolation::kCubic;
  return out;
}

class Labels : public ::testing::TestWithParam<Lattice> {};

// Known because none of the varied options is part of the picture's definition.
TEST_P(Labels, AreDrawnAlikeByBricksThreadsTilesMemoryAndVisibility) {
  const DenseVolume volume = labelBodies();
  const auto large = makeStore(volume, "large", 64, true), small = makeStore(volume, "small", 16, true);
  int shown = 0;
  for (std::uint64_t seed = 40; seed < casesOf(43u, 41u); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = labelRequest(seed, volume, GetParam());
    request.visibility.method = VisibilityMethod::kNone;
    const Image truth = draw(large, request);
    shown += showsSomething(truth) ? 1 : 0;
    EXPECT_TRUE(equalBits(truth, draw(small, request))) << "bricks of 16";
    request.visibility.method = VisibilityMethod::kMask;
    EXPECT_TRUE(equalBits(truth, draw(small, request))) << "tested for visibility";
    const ThreadLimit one(1);
    request.tile_px = 128;
    EXPECT_TRUE(equalBits(truth, draw(small, request, 2u << 20))) << "one thread, other tiles, little memory";
    request.crop = PixelRect{21, 13, 70, 57};
    EXPECT_TRUE(equalBits(partOf(truth, *request.crop), draw(small, request))) << "cropped";
  }
  EXPECT_GT(shown, casesOf(1, 0));
}

// Known because none of the varied options is part of the picture's definition.
TEST(LabelVolumes, WithAnotherVolumeAreDrawnAlike) {
  const DenseVolume volume = labelBodies();
  const DenseVolume amounts = cheese({{40, 41, 39}, VoxelType::u8, anisotropicAffine()}, 4, {0, 200});
  const auto stores = [&](int brick_size, const char* name) {
    return std::vector{makeStore(volume, std::string(name) + "_labels", brick_size, true),
                       makeStore(amounts, std::string(name) + "_amounts", brick_size)};
  };
  const auto large = stores(64, "large"), small = stores(16, "small");
  FrameRequest request = labelRequest(44, volume, Lattice::kPixel);
  const TransferFunction fog{request.transfer_function.unit, {{20, {1, 1, 1}, 0}, {200, {1, 0.8, 0.6}, 0.03}}};
  request.volumes = {{request.transfer_function, {}, {}}, {fog, {}, {}}};
  const Image truth = draw(large, request);
  EXPECT_TRUE(showsSomething(truth));
  EXPECT_TRUE(equalBits(truth, draw(small, request))) << "bricks of 16";
  const ThreadLimit one(1);
  request.tile_px = 128;
  EXPECT_TRUE(equalBits(truth, draw(small, request))) << "one thread, other tiles";
}

// Known because labels absent from the volume change no picture, even if ranges of the volume include them.
TEST_P(Labels, SkippingChangesNoBit) {
  DenseVolume volume = labelBodies();
  for (std::int64_t z = 0; z < 37; ++z) {
    for (std::int64_t y = 0; y < 39; ++y) {
      for (std::int64_t x = 20; x < 44; ++x) volume.set(x, y, z, (x + y + z) % 3 == 0 ? 40 : 0);
    }
  }
  const auto store = makeStore(volume, "labels", 16, true);
  std::uint64_t interesting = 0, with_all = 0;
  for (std::uint64_t seed = 60; seed < 64; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FrameRequest request = labelRequest(seed, volume, GetParam());
    request.level.reset();
    std::erase_if(request.transfer_function.labels, [](const LabelStyle& look) { return look.label == 40; });
    request.transfer_function.labels.push_back({201, "", glm::dvec3(1), 0.5});
    FrameStatistics few, many;
    const Image truth = draw(store, request, 1u << 30, &few);
    std::vector<LabelStyle>& labels = request.transfer_function.labels;
    for (int label = 1; label < 200; ++label) {
      if (label % 40 != 0) labels.push_back({static_cast<double>(label), "", glm::dvec3(1), 1});
    }
    std::sort(labels.begin(), labels.end(), [](const LabelStyle& a, const LabelStyle& b) { return a.label < b.label; });
    EXPECT_TRUE(equalBits(truth, draw(store, request, 1u << 30, &many)));
    interesting += few.bricks_interesting, with_all += many.bricks_interesting;
  }
  EXPECT_LT(interesting, with_all);
}

// For a label absent from the store, no brick is read.
TEST_P(Labels, WhatNoRangeHoldsIsNotRead) {
  const DenseVolume volume = labelBodies();
  const auto store = makeStore(volume, "labels", 16, true);
  FrameRequest request = labelRequest(1, volume, GetParam());
  request.transfer_function.labels = {{201, "", glm::dvec3(1), 1}};
  FrameStatistics statistics;
  EXPECT_FALSE(showsSomething(draw(store, request, 1u << 30, &statistics)));
  EXPECT_EQ(statistics.bricks_read, 0u);
}

INSTANTIATE_TEST_SUITE_P(Lattices, Labels, ::testing::ValuesIn(kLattices),
                         [](const auto& info) { return std::string(nameOf(info.param)); });

}  // namespace
}  // namespace kiln::test
