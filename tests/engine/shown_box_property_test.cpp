// The box and the outline that a picture shows. Known answers: a box of opaque voxels in air is found to the voxel in a
// store of one brick, and within a cube of the index in larger stores. Properties: no shown voxel is outside the box;
// in no direction does a shown voxel reach beyond the outline, but by its stated share.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "engine/shown_box.h"
#include "store/ranges/sub_bricks.h"
#include "store/store_reader.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr Extent3 kDims{70, 52, 45};
// A volume whose views have voxels of 4³ voxels.
constexpr Extent3 kLong{270, 52, 45};

DenseVolume airWith(const VoxelBox& box, double value, const Extent3& dims = kDims) {
  DenseVolume out = fill({dims}, [](std::int64_t, std::int64_t, std::int64_t) { return 0.0; });
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
                 bool read_level = true) {
  return shownBox(store, std::vector{function}, clipping, read_level).box;
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
    for (const std::int64_t brick : {8, 16, 32, 128}) {
      const StoreReader store(makeStore(airWith(box, 255), "box" + std::to_string(brick), brick));
      const std::int64_t most = brick / subBricksOf(brick) + store.manifest().apron;
      expectAround(shownIn(store, rampTo(1), {}, false), box, most, where);
      // The voxels of few bricks show the box, and the voxel beside it, in which values are interpolated. Means of
      // voxels of a coarser level may lose a thin layer.
      const VoxelBox refined = shownIn(store, rampTo(1));
      if (brick >= 16)
        expectAround(refined, box, 1, where);
      else
        expectAround(dilated(refined, most), box, 2 * most, where);
    }
  }
}

TEST(ShownBox, NothingShown_isEmpty) {
  const StoreReader store(makeStore(airWith({{10, 10, 10}, {20, 20, 20}}, 90), "nothing"));
  EXPECT_TRUE(shownIn(store, rampTo(1)).empty());
  EXPECT_TRUE(shownBox(store, std::vector{rampTo(1)}, {}).outline.empty());
}

glm::dvec3 randomDirection(std::mt19937& random) {
  std::normal_distribution<double> part;
  return glm::normalize(glm::dvec3(part(random), part(random), part(random)));
}

double reachOf(const std::vector<glm::dvec3>& points, const glm::dvec3& direction) {
  double out = -INFINITY;
  for (const glm::dvec3& point : points) out = std::max(out, glm::dot(point, direction));
  return out;
}

// A ball of radius 20 reaches 20 in every direction, a box around it up to 34.6. A cell reaches a voxel further; in a
// store whose level of one brick has voxels of 8, eight.
TEST(ShownOutline, OfABall_isRound) {
  const glm::dvec3 centre(26, 25, 22);
  DenseVolume volume = fill({kDims}, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return glm::distance(glm::dvec3(x, y, z), centre) <= 20 ? 255.0 : 0.0;
  });
  for (int axis = 0; axis < 3; ++axis) {
    volume.geometry.world_from_index[axis][axis] = 0.5;
    volume.geometry.world_from_index[3][axis] = -100;
  }
  std::mt19937 random(5);
  for (const std::int64_t brick : {16, 128}) {
    const StoreReader store(makeStore(volume, "round" + std::to_string(brick), brick));
    const std::vector<glm::dvec3> outline = shownBox(store, std::vector{rampTo(1)}, {}).outline;
    const double span = brick == 16 ? 8 : 1;
    for (int n = 0; n < 200; ++n) {
      const glm::dvec3 direction = randomDirection(random);
      const double reach = 2 * (reachOf(outline, direction) - glm::dot(0.5 * centre - 100.0, direction));
      EXPECT_GE(reach, 20 * 0.995) << brick;
      EXPECT_LE(reach, 20 + 2 * std::sqrt(3.0) * span) << brick;
    }
  }
}

// The ends of a rod that lies aslant are the ends of its outline, and its box has six more corners.
TEST(ShownOutline, ContainsWhatShows) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(8, 36);
  for (int n = 0; n < 8; ++n) {
    const glm::dvec3 from(place(random), place(random), place(random)), to(place(random), place(random), place(random));
    DenseVolume volume = airWith({}, 0);
    std::vector<glm::dvec3> centres;
    for (int i = 0; i <= 200; ++i) {
      const glm::dvec3 at = glm::floor(glm::mix(from, to, i / 200.0));
      volume.set(static_cast<std::int64_t>(at.x), static_cast<std::int64_t>(at.y), static_cast<std::int64_t>(at.z),
                 255);
      centres.push_back(at);
    }
    for (const std::int64_t brick : {16, 128}) {
      const StoreReader store(makeStore(volume, "aslant" + std::to_string(brick), brick));
      const std::vector<glm::dvec3> outline = shownBox(store, std::vector{rampTo(1)}, {}).outline;
      for (int k = 0; k < 100; ++k) {
        const glm::dvec3 direction = randomDirection(random);
        const double reach = reachOf(outline, direction), shown = reachOf(centres, direction);
        EXPECT_GE(reach, shown) << "rod " << n << ", bricks of " << brick;
        EXPECT_LE(reach, shown + (brick == 128 ? 3 : 24)) << "rod " << n;
      }
    }
  }
}

// Known by halves: behind an oblique plane, nothing is left of the corner that the box of the rest still has.
TEST(ShownOutline, ObliquePlanes_cut) {
  const StoreReader store(makeStore(airWith({{10, 10, 10}, {40, 40, 40}}, 255), "oblique_outline", 128));
  Clipping cut;
  cut.planes = {{{-1, -1, -1}, 40.0}};  // x + y + z <= 40
  const std::vector<glm::dvec3> outline = shownBox(store, std::vector{rampTo(1)}, cut).outline;
  EXPECT_NEAR(reachOf(outline, {1, 1, 1}), 40, 6);  // a cell that the plane cuts reaches 4.5 to 6 further
  const std::vector<glm::dvec3> whole = shownBox(store, std::vector{rampTo(1)}, {}).outline;
  EXPECT_NEAR(reachOf(whole, {1, 1, 1}), 3 * 39.5, 3);
}

// A ray through 10 voxels of opacity o has the alpha 1 - (1 - o)^10: of 0.0002 it is 0.002, of 0.003 it is 0.03, which
// is 49 of 255 steps of sRGB in white on black. No cube of 8 voxels has an alpha of 1/32.
TEST(ShownBox, Haze_countsByTheWholeRay) {
  const VoxelBox box = {{30, 20, 20}, {40, 30, 30}};
  for (const std::int64_t brick : {16, 128}) {
    const StoreReader store(makeStore(airWith(box, 255), "haze" + std::to_string(brick), brick));
    EXPECT_TRUE(shownIn(store, rampTo(0.0002)).empty());
    const std::int64_t most = brick == 128 ? 1 : 16;  // two voxels of the level that is one brick
    expectAround(shownIn(store, rampTo(0.003)), box, most, std::to_string(brick));
  }
}

// A ball of radius 20 has a disc of 1257 pixels: one voxel elsewhere is 0.08 % of the opacity, nine are 0.7 %.
TEST(ShownBox, Specks_doNotMoveTheBox) {
  const auto volumeWith = [](std::int64_t edge) {
    return fill({kDims}, [edge](std::int64_t x, std::int64_t y, std::int64_t z) {
      const std::int64_t dx = x - 25, dy = y - 25, dz = z - 22;
      const bool in_ball = dx * dx + dy * dy + dz * dz <= 400,
                 in_speck = x >= 66 && x < 66 + edge && y >= 45 && y < 45 + edge && z >= 38 && z < 38 + edge;
      return in_ball || in_speck ? 255.0 : 0.0;
    });
  };
  const TransferFunction solid{1, {{254, glm::dvec3(1), 0}, {254.5, glm::dvec3(1), 1}}};
  const VoxelBox ball = {{5, 5, 2}, {46, 46, 43}};
  for (const std::int64_t brick : {8, 16, 128}) {
    // With bricks of 8 voxels the camera sees voxels of twice the size.
    const StoreReader small(makeStore(volumeWith(1), "speck" + std::to_string(brick), brick));
    if (brick >= 16) expectAround(shownIn(small, solid), ball, 1, "speck");
    const StoreReader large(makeStore(volumeWith(3), "spot" + std::to_string(brick), brick));
    const VoxelBox both = shownIn(large, solid);
    EXPECT_GE(both.hi.x, 69) << brick;
    EXPECT_GE(both.hi.y, 48) << brick;
  }
  // Without the ball, the speck is all there is.
  const StoreReader alone(makeStore(airWith({{66, 45, 38}, {67, 46, 39}}, 255), "alone", 128));
  expectAround(shownIn(alone, solid), {{66, 45, 38}, {67, 46, 39}}, 1, "alone");
}

// A rod of one voxel is less than a thousandth of the body that it touches, and is seen.
TEST(ShownBox, ThinParts_stay) {
  for (const Extent3& dims : {kDims, kLong}) {
    DenseVolume volume = airWith({{5, 5, 5}, {40, 45, 40}}, 255, dims);
    for (std::int64_t x = 40; x < 60; ++x) volume.set(x, 25, 20, 255);
    for (const std::int64_t brick : {16, 128}) {
      const StoreReader store(makeStore(volume, "rod" + std::to_string(brick), brick));
      EXPECT_GE(shownIn(store, rampTo(1)).hi.x, 60) << brick << " of " << dims.x;
    }
  }
}

// A face with a window is opaque everywhere in the volume; with the function's colours, where the function is not 0.
TEST(ShownBox, SectionsCount) {
  const VoxelBox box = {{20, 20, 20}, {30, 30, 30}};
  const StoreReader store(makeStore(airWith(box, 255), "section", 128));
  Clipping cut;
  cut.planes = {{{0, 1, 0}, -25.0}};  // y >= 25
  expectAround(shownIn(store, rampTo(1), cut), {{20, 25, 20}, {30, 30, 30}}, 1, "no section");
  cut.section = Section{"gray", glm::dvec2(128, 255), 1};
  expectAround(shownIn(store, rampTo(1), cut), {{0, 25, 0}, {kDims.x, 30, kDims.z}}, 1, "window");
  cut.section = Section{};
  expectAround(shownIn(store, rampTo(0.0001), cut), {{20, 25, 20}, {30, 26, 30}}, 1, "function");
  cut.section.reset();
  EXPECT_TRUE(shownIn(store, rampTo(0.0001), cut).empty());
}

// Known by halves: an oblique plane through the corner of a cube leaves a smaller box.
TEST(ShownBox, ObliquePlanes_cutTheBox) {
  const StoreReader store(makeStore(airWith({{10, 10, 10}, {40, 40, 40}}, 255), "oblique", 128));
  Clipping cut;
  cut.planes = {{{-1, -1, -1}, 40.0}};  // x + y + z <= 40
  expectAround(shownIn(store, rampTo(1), cut), {{10, 10, 10}, {21, 21, 21}}, 3, "oblique");
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

// Cubes at the border of an object reach up to 16 voxels beyond the object, which the level of one brick shows.
TEST(ShownOutline, OfAnObjectInSeveralBricks_endsAtTheObject) {
  const VoxelBox box = {{17, 18, 19}, {50, 30, 33}};
  DenseVolume volume = fill({{150, 52, 45}}, [](std::int64_t, std::int64_t, std::int64_t) { return 0.0; });
  forEachCoord(box, [&](const VoxelCoord& at) { volume.set(at.x, at.y, at.z, 255); });
  const StoreReader store(makeStore(volume, "beyond", 128));
  ASSERT_EQ(store.index().lattice(0).count(), 2);
  const ShownBox shown = shownBox(store, std::vector{rampTo(1)}, {});
  expectAround(shown.box, box, 3, "box");
  EXPECT_LE(reachOf(shown.outline, {1, 0, 0}), 53);
  EXPECT_LE(reachOf(shown.outline, {0, 0, -1}), -15);
}

// A cube of the index beside a brick's face holds the values of the apron, up to six voxels beyond the cube.
TEST(ShownOutline, OfABallInSeveralBricks_isRound) {
  constexpr double kRadius = 60;
  const glm::dvec3 centre(74.5);
  const DenseVolume volume = fill({{150, 150, 150}}, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return glm::distance(glm::dvec3(x, y, z), centre) <= kRadius ? 255.0 : 0.0;
  });
  const StoreReader store(makeStore(volume, "ball_of_bricks", 128));
  ASSERT_EQ(store.index().lattice(0).count(), 8);
  const std::vector<glm::dvec3> outline = shownBox(store, std::vector{rampTo(1)}, {}).outline;
  std::mt19937 random(13);
  for (int n = 0; n < 200; ++n) {
    const glm::dvec3 direction = randomDirection(random);
    const double reach = reachOf(outline, direction) - glm::dot(centre, direction);
    EXPECT_GE(reach, kRadius * 0.995);
    EXPECT_LE(reach, kRadius + 2 * std::sqrt(3.0) * 2);
  }
}

// A faint beam of 40 voxels shows along its axis alone: 0.004 of the light there, 0.0008 across.
TEST(ShownOutline, PartsThatOneSideShows) {
  DenseVolume volume = airWith({{5, 5, 5}, {9, 9, 9}}, 255);
  forEachCoord(VoxelBox{{20, 30, 30}, {60, 38, 38}}, [&](const VoxelCoord& at) { volume.set(at.x, at.y, at.z, 101); });
  const StoreReader store(makeStore(volume, "beam", 128));
  const TransferFunction function{1, {{100, glm::dvec3(1), 0}, {101, glm::dvec3(1), 0.0001}, {255, glm::dvec3(1), 1}}};
  const ShownBox shown = shownBox(store, std::vector{function}, {});
  EXPECT_GE(shown.box.hi.y, 38);
  EXPECT_GE(reachOf(shown.outline, {1, 0, 0}), 59);
  EXPECT_GE(reachOf(shown.outline, {0, 1, 0}), 37);
}

// Cubes that hold labels above and below a shown label do not hold that label.
TEST(ShownBox, Labels_betweenOthers) {
  DenseVolume labels = fill({kDims}, [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<double>(1 + 8 * ((x / 3 + y / 3 + z / 3) % 2));
  });
  for (std::int64_t z = 12; z < 24; ++z) {
    for (std::int64_t y = 12; y < 24; ++y) {
      for (std::int64_t x = 20; x < 36; ++x) labels.set(x, y, z, 5);
    }
  }
  const StoreReader store(makeStore(labels, "between", 64, true));
  TransferFunction function;
  function.labels = {{1, "a", glm::dvec3(1), 0}, {5, "b", glm::dvec3(1), 1}, {9, "c", glm::dvec3(1), 0}};
  expectAround(shownIn(store, function), {{20, 12, 12}, {36, 24, 24}}, 2, "between");
}

}  // namespace
}  // namespace kiln::test
