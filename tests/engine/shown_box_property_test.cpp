// The box that a picture shows. Known answers: a box of opaque voxels in air is found to the voxel in a store of one
// brick, and within a cube of the index in larger stores. Property: no shown voxel is outside.
#include <gtest/gtest.h>

#include <random>

#include "engine/shown_box.h"
#include "store/ranges/sub_bricks.h"
#include "store/store_reader.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr Extent3 kDims{70, 52, 45};

DenseVolume airWith(const VoxelBox& box, double value) {
  DenseVolume out = fill({kDims}, [](std::int64_t, std::int64_t, std::int64_t) { return 0.0; });
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) out.set(x, y, z, value);
    }
  }
  return out;
}

// Opacity `most` at 255, none at 0.
TransferFunction rampTo(double most) { return {1, {{100, glm::dvec3(1), 0}, {200, glm::dvec3(1), most}}}; }

VoxelBox shownIn(const StoreReader& store, const TransferFunction& function, const Clipping& clipping = {},
                 bool read_brick = true) {
  return shownBox(store, std::vector{function}, clipping, read_brick).box;
}

void expectAround(const VoxelBox& found, const VoxelBox& box, std::int64_t most, const std::string& where) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(found.lo[axis], box.lo[axis]) << where;
    EXPECT_GE(found.lo[axis], box.lo[axis] - most) << where;
    EXPECT_GE(found.hi[axis], box.hi[axis]) << where;
    EXPECT_LE(found.hi[axis], box.hi[axis] + most) << where;
  }
}

TEST(ShownBox, BoxInAir_isFoundWithinACube) {
  std::mt19937 random(3);
  for (int n = 0; n < 12; ++n) {
    VoxelBox box;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t last = kDims[axis] - 8;
      box.lo[axis] = std::uniform_int_distribution<std::int64_t>(3, last)(random);
      box.hi[axis] = std::uniform_int_distribution<std::int64_t>(box.lo[axis] + 1, last + 5)(random);
    }
    const std::string where = "case " + std::to_string(n);
    for (const std::int64_t brick : {16, 32, 128}) {
      const StoreReader store(makeStore(airWith(box, 255), "box" + std::to_string(brick), brick));
      const std::int64_t most = brick / subBricksOf(brick) + store.manifest().apron;
      expectAround(shownIn(store, rampTo(1), {}, false), box, most, where);
      // The voxels of one brick show the box, and the voxel beside it, in which values are interpolated. Means of
      // voxels may lose a thin layer.
      const VoxelBox refined = shownIn(store, rampTo(1));
      if (brick == 128)
        expectAround(refined, box, 1, where);
      else
        expectAround(dilated(refined, most), box, 2 * most, where);
    }
  }
}

TEST(ShownBox, NothingShown_isEmpty) {
  const StoreReader store(makeStore(airWith({{10, 10, 10}, {20, 20, 20}}, 90), "nothing"));
  EXPECT_TRUE(shownIn(store, rampTo(1)).empty());
}

// A cube of 4 voxels with opacity o per voxel has the alpha 1 - (1 - o)^4: of 0.004 it is 0.016, of 0.02 it is 0.078.
TEST(ShownBox, Haze_isLeftOut) {
  const VoxelBox box = {{30, 20, 20}, {40, 30, 30}};
  const StoreReader store(makeStore(airWith(box, 255), "haze", 16));
  ASSERT_EQ(16 / subBricksOf(16), 8);
  EXPECT_TRUE(shownIn(store, rampTo(0.003)).empty());
  EXPECT_FALSE(shownIn(store, rampTo(0.02)).empty());
}

TEST(ShownBox, AllFunctionsCount) {
  const VoxelBox box = {{30, 20, 20}, {40, 30, 30}};
  const StoreReader store(makeStore(airWith(box, 255), "functions", 128));
  const TransferFunction air{1, {{0, glm::dvec3(1), 1}, {50, glm::dvec3(1), 0}}};
  EXPECT_EQ(shownBox(store, std::vector{rampTo(1), air}, {}).box, boxOf(kDims));
}

TEST(ShownBox, Clipping_cutsTheBox) {
  const VoxelBox box = {{10, 10, 10}, {60, 45, 40}};
  const StoreReader store(makeStore(airWith(box, 255), "clipped", 128));
  Clipping region;
  region.region = VoxelBox{{20, 0, 15}, {30, 52, 18}};
  const VoxelBox in_region = shownIn(store, rampTo(1), region);
  expectAround(in_region, {{20, 10, 15}, {30, 45, 18}}, 1, "region");
  EXPECT_EQ(in_region.lo.x, 20);
  EXPECT_EQ(in_region.hi.x, 30);
  Clipping plane;
  plane.planes = {{{1, 0, 0}, -30.0}};  // x >= 30 in a world whose voxel 0 is at 0
  const VoxelBox cut = shownIn(store, rampTo(1), plane);
  EXPECT_EQ(cut.lo.x, 30);
  EXPECT_NEAR(static_cast<double>(cut.hi.x), 60, 1);
  // A partial image has the camera of the whole picture.
  Clipping part;
  part.part = VoxelBox{{0, 0, 0}, {16, 16, 16}};
  EXPECT_EQ(shownIn(store, rampTo(1), part), shownIn(store, rampTo(1)));
}

TEST(ShownBox, ClipRegionAlone_isExact) {
  VolumeGeometry volume;
  volume.dims = kDims;
  Clipping clipping;
  clipping.region = VoxelBox{{5, 6, 7}, {15, 26, 37}};
  clipping.planes = {{{0, -2, 0}, 20}};  // y <= 10
  EXPECT_EQ(boxOfClip(volume, clipping), (VoxelBox{{5, 6, 7}, {15, 11, 37}}));
  EXPECT_EQ(boxOfClip(volume, {}), boxOf(kDims));
}

TEST(ShownBox, Labels_thatAreShown) {
  DenseVolume labels = airWith({{5, 5, 5}, {60, 45, 40}}, 3);
  for (std::int64_t x = 20; x < 25; ++x) labels.set(x, 21, 22, 7);
  const StoreReader store(makeStore(labels, "labels", 128, true));
  TransferFunction function;
  function.labels = {{3, "body", glm::dvec3(1), 0}, {7, "organ", glm::dvec3(1), 1}};
  expectAround(shownIn(store, function), {{20, 21, 22}, {25, 22, 23}}, 1, "label");
}

}  // namespace
}  // namespace kiln::test
