// The coarser levels of a store against the plain loops that define them (FORMAT.md, lattice).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <map>

#include "grid/pyramid.h"
#include "store/store_reader.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/sub_bricks.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// A level as an array of doubles, which represent every value of the tested types.
struct Level {
  VolumeGeometry geometry;
  std::vector<double> values;
  double at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const Extent3& n = geometry.dims;
    return values[static_cast<std::size_t>((z * n.y + y) * n.x + x)];
  }
};

template <class F>
void forEachVoxel(const VoxelBox& box, F&& f) {
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) f(x, y, z);
    }
  }
}

Level finest(const DenseVolume& volume) {
  Level out{volume.geometry, {}};
  forEachVoxel(boxOf(volume.geometry.dims),
               [&](auto x, auto y, auto z) { out.values.push_back(volume.valueAt(x, y, z)); });
  return out;
}

VoxelBox voxelsBelow(const VoxelBox& coarse, const Extent3& by, const Extent3& fine_dims) {
  return intersection({{coarse.lo.x * by.x, coarse.lo.y * by.y, coarse.lo.z * by.z},
                       {coarse.hi.x * by.x, coarse.hi.y * by.y, coarse.hi.z * by.z}},
                      boxOf(fine_dims));
}

// Returns the mean of the existing voxels, rounded to the nearest value of the type, halves up.
Level halved(const Level& fine, VoxelType type) {
  const Extent3 by = halvingOf(fine.geometry);
  Level out{coarserThan(fine.geometry), {}};
  forEachVoxel(boxOf(out.geometry.dims), [&](auto x, auto y, auto z) {
    double sum = 0;
    int count = 0;
    forEachVoxel(voxelsBelow({{x, y, z}, {x + 1, y + 1, z + 1}}, by, fine.geometry.dims), [&](auto i, auto j, auto k) {
      if (std::isnan(fine.at(i, j, k))) return;
      sum += fine.at(i, j, k);
      ++count;
    });
    const double mean = sum / count;
    out.values.push_back(type == VoxelType::f32 ? static_cast<double>(static_cast<float>(mean))
                                                : std::floor(mean + 0.5));
  });
  return out;
}

// Returns the most frequent of the existing labels; among equally frequent labels the smallest that is not 0.
Level halvedLabels(const Level& fine) {
  const Extent3 by = halvingOf(fine.geometry);
  Level out{coarserThan(fine.geometry), {}};
  forEachVoxel(boxOf(out.geometry.dims), [&](auto x, auto y, auto z) {
    std::map<double, int> counts;
    forEachVoxel(voxelsBelow({{x, y, z}, {x + 1, y + 1, z + 1}}, by, fine.geometry.dims),
                 [&](auto i, auto j, auto k) { ++counts[fine.at(i, j, k)]; });
    int most = 0;
    for (const auto& [label, count] : counts) most = std::max(most, count);
    std::erase_if(counts, [&](const auto& label) { return label.second < most; });
    if (counts.size() > 1) counts.erase(0);
    out.values.push_back(counts.begin()->first);
  });
  return out;
}

ValueRange rangeIn(const Level& level, const VoxelBox& box) {
  ValueRange out;
  forEachVoxel(intersection(box, boxOf(level.geometry.dims)),
               [&](auto x, auto y, auto z) { out.include(level.at(x, y, z)); });
  return out;
}

void expectPyramid(const DenseVolume& volume, const StoreReader& store) {
  std::vector<Level> levels = {finest(volume)};
  const int count = static_cast<int>(store.manifest().levels.size());
  for (int l = 0; l < count; ++l) {
    SCOPED_TRACE("level " + std::to_string(l));
    const bool labels = store.manifest().volume_class == VolumeClass::kLabels;
    if (l > 0) levels.push_back(labels ? halvedLabels(levels.back()) : halved(levels.back(), volume.type));
    const Level& level = levels.back();
    ASSERT_EQ(store.level(l).geometry.dims, level.geometry.dims);
    EXPECT_EQ(store.level(l).geometry.world_from_index, level.geometry.world_from_index);
    for (std::int64_t i = 0; i < store.level(l).bricks.count(); ++i) {
      const BrickKey key{l, brickAt(store.level(l).bricks, i)};
      const BrickBlock block = store.read(key);
      const BrickEntry& entry = store.index().at(key);
      int wrong = 0;
      forEachVoxel(block.extent, [&](auto x, auto y, auto z) {
        const auto inside = [](std::int64_t v, std::int64_t n) { return std::clamp<std::int64_t>(v, 0, n - 1); };
        const Extent3& n = level.geometry.dims;
        const double expected = level.at(inside(x, n.x), inside(y, n.y), inside(z, n.z));
        const double found = withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
          return static_cast<double>(block.data<T>()[block.offsetOf({x, y, z})]);
        });
        wrong += !(found == expected || (std::isnan(found) && std::isnan(expected)));
      });
      ASSERT_EQ(wrong, 0) << "brick " << i;
      // Ranges of bricks and cells cover every finer level, including interpolation at each level.
      VoxelBox core = block.core;
      for (int below = l; below >= 0; --below) {
        const Level& fine = levels[static_cast<std::size_t>(below)];
        EXPECT_TRUE(entry.core.contains(rangeIn(fine, core)));
        EXPECT_TRUE(entry.support.contains(rangeIn(fine, dilated(core, 2))));
        if (below > 0) {
          const Level& finer = levels[static_cast<std::size_t>(below) - 1];
          core = voxelsBelow(core, halvingOf(finer.geometry), finer.geometry.dims);
        }
      }
      // A sub-brick's range covers only voxels of its own level.
      if (!entry.constant) {
        forEachSubBrick(block.core, store.manifest().brick_size, level.geometry.dims,
                        [&](std::size_t sub_brick, const VoxelBox& voxels) {
                          const ValueRange found = entry.sub_ranges->at(sub_brick, entry.support);
                          EXPECT_TRUE(found.contains(rangeIn(level, voxels))) << "sub-brick " << sub_brick;
                        });
      }
      const int edge = block.octree.edge(0);
      ValueRange cells;
      for (int c = 0; c < edge * edge * edge; ++c) {
        const VoxelCoord lo = {block.core.lo.x + c % edge * kCellSize, block.core.lo.y + c / edge % edge * kCellSize,
                               block.core.lo.z + c / edge / edge * kCellSize};
        VoxelBox cell =
            intersection({lo, {lo.x + kCellSize, lo.y + kCellSize, lo.z + kCellSize}}, boxOf(level.geometry.dims));
        ValueRange below;
        if (cell.empty()) continue;
        for (int at = l; at > 0; --at) {
          const Level& finer = levels[static_cast<std::size_t>(at) - 1];
          cell = voxelsBelow(cell, halvingOf(finer.geometry), finer.geometry.dims);
        }
        below.include(rangeIn(levels.front(), cell));
        const ValueRange& stored = block.octree.cells()[static_cast<std::size_t>(c)];
        EXPECT_TRUE(stored.contains(below));
        // Means lie between their inputs, so only the finest voxels determine the range.
        EXPECT_EQ(stored, below);
        cells.include(stored);
      }
      EXPECT_EQ(entry.core, cells);
    }
  }
}

// Known because the volume is in memory: the loops above compute every level.
TEST(Pyramid, IsTheMeanOfWhatExists) {
  const std::uint64_t first = 4711;
  std::cout << "seeds from " << first << '\n';
  const VoxelType types[] = {VoxelType::u8, VoxelType::i16, VoxelType::u16, VoxelType::i32, VoxelType::f32};
  for (std::uint64_t seed = first; seed < first + casesOf(20u, 10u); ++seed) {
    Random random(seed);
    const VoxelType type = types[seed % 5];
    const Extent3 dims = {random.between(1, 45), random.between(1, 45), random.between(1, 30)};
    SCOPED_TRACE("seed " + std::to_string(seed) + ", " + std::to_string(dims.x) + "x" + std::to_string(dims.y) + "x" +
                 std::to_string(dims.z));
    const glm::dmat4 affine = seed % 3 == 0 ? glm::dmat4(1.0) : seed % 3 == 1 ? anisotropicAffine() : obliqueAffine();
    DenseVolume volume = cheese({dims, type, affine}, seed, usualRange(type));
    if (type == VoxelType::f32) {
      auto* voxels = reinterpret_cast<float*>(volume.voxels.data());
      for (std::int64_t i = 0; i < dims.count(); ++i) {
        if (random.chance(0.3)) voxels[i] = std::nanf("");
      }
    }
    const std::int64_t brick_size = seed % 2 == 0 ? 8 : 16;
    expectPyramid(volume, StoreReader(makeStore(volume, "pyramid", brick_size)));
    if (HasFatalFailure()) return;
  }
}

// Levels of labels, whose values are names. Few labels make ties frequent, including ties with 0 and with labels below
// 0.
TEST(Pyramid, OfLabelsIsTheMostFrequent) {
  const std::uint64_t first = 815;
  std::cout << "seeds from " << first << '\n';
  const VoxelType types[] = {VoxelType::u8, VoxelType::i16, VoxelType::u32, VoxelType::i32};
  for (std::uint64_t seed = first; seed < first + casesOf(12u, 4u); ++seed) {
    Random random(seed);
    const VoxelType type = types[seed % 4];
    const Extent3 dims = {random.between(1, 45), random.between(1, 45), random.between(1, 30)};
    SCOPED_TRACE("seed " + std::to_string(seed));
    const glm::dmat4 affine = seed % 3 == 0 ? glm::dmat4(1.0) : seed % 3 == 1 ? anisotropicAffine() : obliqueAffine();
    const bool below_zero = type == VoxelType::i16 || type == VoxelType::i32;
    const DenseVolume volume = noise({dims, type, affine}, seed, {below_zero ? -2.0 : 0.0, 3});
    expectPyramid(volume, StoreReader(makeStore(volume, "labels", seed % 2 == 0 ? 8 : 16, true)));
    if (HasFatalFailure()) return;
  }
}

// Known by hand: eight voxels each.
TEST(Pyramid, OfLabelsTakesTheSmallestOfEqualsThatIsNot0) {
  struct Case {
    std::array<int, 8> labels;
    int expected;
  };
  const Case cases[] = {{{7, 7, 7, 7, 7, 7, 7, 7}, 7}, {{0, 0, 0, 0, 5, 5, 5, 5}, 5}, {{9, 9, 9, 9, 5, 5, 5, 5}, 5},
                        {{0, 0, 0, 9, 9, 9, 5, 5}, 9}, {{0, 0, 0, 0, 0, 9, 9, 9}, 0}, {{1, 2, 3, 4, 5, 6, 7, 8}, 1},
                        {{0, 8, 7, 6, 5, 4, 3, 2}, 2}, {{0, 0, 8, 8, 4, 4, 1, 3}, 4}};
  const DenseVolume volume = fill({{16, 16, 16}, VoxelType::u8}, [&](auto x, auto y, auto z) {
    return cases[x / 2].labels[static_cast<std::size_t>(x % 2 + 2 * (y % 2) + 4 * (z % 2))];
  });
  const BrickBlock block = StoreReader(makeStore(volume, "ties", 8, true)).read({1, {0, 0, 0}});
  for (std::int64_t x = 0; x < 8; ++x)
    EXPECT_EQ(block.data<std::uint8_t>()[block.offsetOf({x, 3, 5})], cases[x].expected) << "case " << x;
}

// Known by the rule: 1 × 1 × 4 halves x and y twice before z joins; an axis of a single voxel never counts.
TEST(Pyramid, HalvesTheAxesThatAreFine) {
  VolumeGeometry fine;
  fine.dims = {100, 100, 40};
  fine.world_from_index[2][2] = 4;
  EXPECT_EQ(halvingOf(fine), (Extent3{2, 2, 1}));
  fine.world_from_index[2][2] = 1.414;
  EXPECT_EQ(halvingOf(fine), (Extent3{2, 2, 2}));
  fine.world_from_index[2][2] = 1.415;
  EXPECT_EQ(halvingOf(fine), (Extent3{2, 2, 1}));
  fine.dims = {1, 100, 40};
  fine.world_from_index[0][0] = 0.01;
  EXPECT_EQ(halvingOf(fine), (Extent3{1, 2, 1}));
  fine.world_from_index[2][2] = 4;
  const std::vector<VolumeGeometry> levels = pyramidOf(fine, 8, 100);
  ASSERT_EQ(levels.size(), 6u);
  EXPECT_EQ(levels[2].dims, (Extent3{1, 25, 40}));
  EXPECT_EQ(levels.back().dims, (Extent3{1, 4, 5}));
  // The centre of the first coarse voxel is the centre of its finer voxels.
  EXPECT_EQ(levels[1].worldOf({0, 0, 0}), fine.worldOf({0, 0.5, 0}));
  EXPECT_EQ(levels[1].worldOf({0, 3, 2}), fine.worldOf({0, 6.5, 2}));
  EXPECT_EQ(pyramidOf(fine, 8, 2).size(), 2u);
}

// Known because voxels alternate between 1 and 3 along x, so every coarse voxel is 2. The mean hides the finer values,
// the range 1 to 3 does not, and a brick of equal means is not constant.
TEST(Pyramid, MeansOfNoiseAreNotConstant) {
  const DenseVolume volume =
      fill({{32, 16, 16}, VoxelType::f32}, [](auto x, auto, auto) { return x % 2 == 0 ? 1.0 : 3.0; });
  const StoreReader store(makeStore(volume, "noise", 16));
  ASSERT_EQ(store.manifest().levels.size(), 2u);
  const BrickEntry& entry = store.index().at({1, {0, 0, 0}});
  EXPECT_FALSE(entry.constant);
  EXPECT_EQ(entry.core, (ValueRange{1, 3}));
  EXPECT_EQ(store.read({1, {0, 0, 0}}).data<float>()[1000], 2.0f);
}

}  // namespace
}  // namespace kiln::test
