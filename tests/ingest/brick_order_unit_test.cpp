// The order of bricks. Known by brute force over all bricks of small lattices, and by a cache that is played through.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "ingest/bytes/block_cache.h"
#include "ingest/source/brick_order.h"

namespace kiln::test {
namespace {

// The box of each brick with its apron, by time.
std::map<ReadTime, VoxelBox> boxesByTime(const BrickOrder& order) {
  const BrickOrder::Lattice& of = order.lattice();
  const Extent3 bricks = brickLattice(of.dims, of.brick_size);
  std::map<ReadTime, VoxelBox> out;
  for (std::int64_t i = 0; i < bricks.count(); ++i) {
    const BrickCoord brick = brickAt(bricks, i);
    const VoxelBox box = intersection(dilated(coreBox(brick, of.brick_size, of.dims), of.apron), boxOf(of.dims));
    EXPECT_EQ(order.timeOfBox(box.lo), order.timeOf(brick));
    EXPECT_TRUE(out.emplace(order.timeOf(brick), box).second) << "two bricks at a time";
  }
  EXPECT_EQ(out.begin()->first, 0);
  EXPECT_EQ(out.rbegin()->first, bricks.count() - 1);
  return out;
}

std::vector<VoxelBox> blocksMeeting(const VoxelBox& box, const Extent3& shape) {
  std::vector<VoxelBox> out;
  for (std::int64_t z = box.lo.z / shape.z * shape.z; z < box.hi.z; z += shape.z)
    for (std::int64_t y = box.lo.y / shape.y * shape.y; y < box.hi.y; y += shape.y)
      for (std::int64_t x = box.lo.x / shape.x * shape.x; x < box.hi.x; x += shape.x)
        out.push_back({{x, y, z}, {x + shape.x, y + shape.y, z + shape.z}});
  return out;
}

// Plays an order through a cache of `kept` blocks. Returns the decodings over the number of blocks.
double decodingsPlayed(const BrickOrder& order, const Extent3& shape, std::uint64_t kept) {
  BlockCache cache;
  cache.setCapacity(kept * BlockCache::kOwnBytes);
  cache.setOrder(order);
  std::set<BlockCache::Key> blocks;
  for (const auto& [time, box] : boxesByTime(order)) {
    for (const VoxelBox& block : blocksMeeting(box, shape)) {
      const BlockCache::Key key{block.lo.z, block.lo.y * 100'000 + block.lo.x};
      cache.get(
          key, [](BlockCache::Bytes) { return BlockCache::Bytes(); }, BlockCache::Use{block, box.lo});
      blocks.insert(key);
    }
  }
  return static_cast<double>(cache.decodings()) / static_cast<double>(blocks.size());
}

struct Case {
  BrickOrder::Lattice lattice;
  Extent3 shape;
};

Case randomCase(std::mt19937_64& random) {
  const auto number = [&](std::int64_t lo, std::int64_t hi) {
    return std::uniform_int_distribution<std::int64_t>(lo, hi)(random);
  };
  Case out;
  out.lattice = {{number(1, 90), number(1, 90), number(1, 90)}, 16, number(1, 6)};
  out.shape = {number(1, 40), number(1, 40), number(1, 40)};
  // Whole slices and rows, as in TIFF.
  if (number(0, 3) == 0) out.shape = {out.lattice.dims.x, number(1, 2) * out.lattice.dims.y, 1};
  return out;
}

TEST(BrickOrder, NextUse_isTheNextBoxThatMeetsABlock) {
  std::mt19937_64 random(901);
  for (int n = 0; n < 40; ++n) {
    const Case c = randomCase(random);
    const BrickOrder order(c.lattice, n % 3, {1 + n % 4, 1 + n % 5});
    const std::map<ReadTime, VoxelBox> boxes = boxesByTime(order);
    for (int k = 0; k < 60; ++k) {
      const auto lo = [&](int axis) {
        return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(c.lattice.dims[axis])) / c.shape[axis] *
               c.shape[axis];
      };
      const VoxelCoord first = {lo(0), lo(1), lo(2)};
      const VoxelBox block = {first, {first.x + c.shape.x, first.y + c.shape.y, first.z + c.shape.z}};
      const auto now = static_cast<ReadTime>(random() % boxes.size());
      auto next = boxes.upper_bound(now);
      while (next != boxes.end() && intersection(next->second, block).empty()) ++next;
      ASSERT_EQ(order.nextUse(block, now), next == boxes.end() ? BrickOrder::kNever : next->first) << n << " " << k;
    }
  }
}

TEST(BrickOrder, CostIsWhatACacheOfThatSizeNeeds) {
  std::mt19937_64 random(902);
  for (int n = 0; n < 60; ++n) {
    const Case c = randomCase(random);
    const BrickOrder order(c.lattice, n % 3, {1 + n % 3, 1 + n % 4});
    const DecodingCost cost = decodingCost(order, c.shape);
    EXPECT_LE(decodingsPlayed(order, c.shape, cost.blocks_kept), cost.decodings + 1e-9) << n;
    EXPECT_NEAR(decodingsPlayed(order, c.shape, 0), decodingsUnkept(c.lattice, c.shape), 1e-9) << n;
  }
}

// Known: with room for all blocks each is decoded once in the order of a store's index. Less room gives orders that
// decode less than layers do with that room.
TEST(BrickOrder, CheapestOrder_fitsIntoItsRoom) {
  const BrickOrder::Lattice lattice = {{256, 256, 256}, 32, 6};
  const Extent3 shape = {32, 32, 32};
  EXPECT_TRUE(cheapestOrder(lattice, shape, 1000).isLayers());
  EXPECT_EQ(decodingsPlayed(cheapestOrder(lattice, shape, 160), shape, 160), 1);
  for (const std::uint64_t room : {120u, 90u, 60u, 40u}) {
    const BrickOrder order = cheapestOrder(lattice, shape, room);
    EXPECT_LE(decodingCost(order, shape).blocks_kept, room);
    const double played = decodingsPlayed(order, shape, room),
                 layers = decodingsPlayed(BrickOrder(lattice), shape, room);
    EXPECT_LT(played, layers) << room;
  }
  // A long volume is swept along its length: a cross-section of it is small.
  EXPECT_EQ(cheapestOrder({{4096, 64, 64}, 32, 6}, shape, 40).sweep(), 0);
}

}  // namespace
}  // namespace kiln::test
