// Boxes of ranks fill the volume and share no voxel, also where there are hardly more voxels than ranks. Known because
// the boxes are counted and intersected.
#include <gtest/gtest.h>

#include "base/error.h"
#include "ranks/rank_boxes.h"
#include "scene/transfer/presets.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

std::vector<VoxelBox> boxesOfRanksIn(const Extent3& dims, int ranks) {
  const StoreReader store(makeStore(noise({dims, VoxelType::u8}, 5, {0, 255}), "rank_boxes", 32));
  return boxesForRanks(store, presetFor("ct-bone", store.manifest()), ranks);
}

TEST(RankBoxes, FillTheVolumeWithoutOverlap) {
  for (const auto& [dims, ranks] : std::vector<std::pair<Extent3, int>>{
           {{1, 1, 33}, 3}, {{1, 1, 33}, 33}, {{3, 2, 1}, 6}, {{3, 3, 3}, 27}, {{40, 33, 70}, 7}, {{40, 33, 70}, 1}}) {
    const std::string of = std::to_string(dims.z) + " " + std::to_string(ranks);
    const std::vector<VoxelBox> found = boxesOfRanksIn(dims, ranks);
    ASSERT_EQ(found.size(), static_cast<std::size_t>(ranks)) << of;
    std::int64_t voxels = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_FALSE(found[i].empty()) << of;
      voxels += found[i].count();
      for (std::size_t j = 0; j < i; ++j) EXPECT_TRUE(intersection(found[i], found[j]).empty()) << of;
    }
    EXPECT_EQ(voxels, dims.count()) << of;
  }
  EXPECT_THROW(boxesOfRanksIn({1, 2, 2}, 5), Error);
}

}  // namespace
}  // namespace kiln::test
