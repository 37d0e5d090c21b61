#include "support/reference/drawn_alike.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "base/thread/parallel.h"
#include "support/reference/drawing.h"
#include "support/reference/scalar_kernels.h"
#include "support/volumes/test_store.h"

namespace kiln::test {

DenseVolume drawnAlikeVolume(int index) {
  if (index == 0) return cheese({{45, 61, 50}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  if (index == 1) return noise({{40, 51, 37}, VoxelType::u8, anisotropicAffine()}, 7, {0, 255});
  return cheese({{40, 57, 35}, VoxelType::f32, obliqueAffine()}, 2, usualRange(VoxelType::f32));
}

std::vector<std::filesystem::path> storesOfThreeBricks(const DenseVolume& volume) {
  std::vector<std::filesystem::path> out;
  for (const std::int64_t size : {8, 16, 64}) out.push_back(makeStore(volume, "of_" + std::to_string(size), size));
  return out;
}

Image expectDrawnAlike(const std::vector<std::filesystem::path>& stores, FrameRequest request, std::uint64_t seed) {
  request.level = 0;
  request.visibility.method = VisibilityMethod::kNone;
  Image truth = draw(stores[2], request);
  for (const auto& store : stores) {
    for (const VisibilityMethod method : {VisibilityMethod::kMask, VisibilityMethod::kRangeTree}) {
      request.visibility.method = method;
      EXPECT_TRUE(equalBits(truth, draw(store, request))) << store;
    }
  }
  const ThreadLimit one(1);
  request.tile_px = 64 << seed % 3;
  EXPECT_TRUE(equalBits(truth, draw(stores[1], request, 1 << 22))) << "tiles of " << request.tile_px;
  request.crop = PixelRect{13, 7, 75, 81};
  EXPECT_TRUE(equalBits(partOf(truth, *request.crop), draw(stores[0], request))) << "crop";
  return truth;
}

void expectAlikeOnInstructionSets(const std::filesystem::path& store, FrameRequest request) {
  for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCatmullRom}) {
    for (const std::optional<int> level : {std::optional(0), std::optional(1), std::optional<int>()}) {
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

}  // namespace kiln::test
