// The memory plan of a conversion, for sources that are never read. Known from the sums in ARCHITECTURE.md.
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "convert/plan.h"

namespace kiln::test {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;

class PlannedSource : public VolumeSource {
 public:
  PlannedSource(const Extent3& dims, ReadOrder order) : order_(order) {
    info_.geometry.dims = dims;
    info_.type = VoxelType::u16;
  }
  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return order_; }
  void read(const VoxelBox&, std::span<std::byte>) override { ADD_FAILURE() << "planning reads nothing"; }
  std::uint64_t decodeBytes() const override { return 3 * kMiB; }

 private:
  SourceInfo info_;
  ReadOrder order_;
};

ConversionPlan planOf(const Extent3& dims, std::uint64_t memory_bytes, ReadOrder order = ReadOrder::kForward) {
  ConvertOptions options;
  options.memory_bytes = memory_bytes;
  return planConversion(PlannedSource(dims, order), options);
}

std::uint64_t smallestFor(const Extent3& dims) {
  std::uint64_t fails = 0, works = 1ull << 40;
  while (works - fails > 1) {
    const std::uint64_t middle = fails + (works - fails) / 2;
    try {
      EXPECT_LE(planOf(dims, middle).total(), middle);
      works = middle;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBudget);
      fails = middle;
    }
  }
  return works;
}

std::uint64_t tablesFor(const Extent3& dims) {
  return tablesBytes(PlannedSource(dims, ReadOrder::kForward).info(), {});
}

TEST(ConversionPlan, TheSmallestMemoryOfAStreamDoesNotDependOnItsSlices) {
  const Extent3 small = {512, 512, 1000}, large = {65536, 65536, 1000};
  EXPECT_EQ(smallestFor(small) - tablesFor(small), smallestFor(large) - tablesFor(large));
  EXPECT_LT(smallestFor({1 << 20, 1 << 8, 1 << 8}), 64 * kMiB);  // a whole row, here 2 MiB, is read at once
}

// A scan of 10,000³ has half a million bricks; voxels 200,000 apart along each axis would be four thousand million.
TEST(ConversionPlan, AnIndexBeyondTheMachineIsRefused) {
  const auto refused = [](const Extent3& dims) {
    try {
      requireRoomForIndex(PlannedSource(dims, ReadOrder::kAnyBox).info(), {});
    } catch (const Error& error) {
      return error.code() == ErrorCode::kBudget;
    }
    return false;
  };
  EXPECT_FALSE(refused({10000, 10000, 10000}));
  EXPECT_TRUE(refused({1 << 22, 1 << 22, 1 << 22}));
}

TEST(ConversionPlan, SlicesAreInMemoryWhereTheyFitBesideTheLanes) {
  const ThreadLimit threads(2);
  const Extent3 dims = {1024, 1024, 1000};  // slices of 2 MiB; a layer of bricks covers 140
  const ConversionPlan ample = planOf(dims, 4096 * kMiB), tight = planOf(dims, 450 * kMiB),
                       small = planOf(dims, 300 * kMiB);
  EXPECT_FALSE(ample.window_on_disk);
  EXPECT_EQ(ample.window_slices, 140 + 128);
  EXPECT_EQ(ample.window_bytes, 268 * 2 * kMiB + 3 * kMiB);
  EXPECT_EQ(ample.scratch_bytes, 0u);
  // Half bricks of three layers: 8 x 8 bricks, then 4 x 4, then 2 x 2 x 2 in all. Each has 64³ voxels and the ranges of
  // 8³ cells, enlarged by 6 voxels along each axis for a neighbour, plus a quarter. A piece for each of seven
  // neighbours is an object of its own.
  const double voxels_bytes = 2.0 * 70 * 70 * 70, ranges_bytes = 16.0 * 8 * 8 * 8, pieces_bytes = 7 * 192;
  EXPECT_NEAR(static_cast<double>(ample.parts_bytes),
              (192 + 48 + 8) * 1.25 * (voxels_bytes + ranges_bytes + pieces_bytes), 80 * 1024);
  EXPECT_FALSE(tight.window_on_disk);
  EXPECT_GE(tight.window_slices, 140);
  EXPECT_LT(tight.window_slices, 268);
  EXPECT_TRUE(small.window_on_disk);
  EXPECT_EQ(small.window_slices, 268);
  EXPECT_EQ(small.window_bytes, 256 * 1024 + 3 * kMiB);
  EXPECT_EQ(small.scratch_bytes, 268 * 2 * kMiB + ample.parts_bytes - small.parts_bytes);
  for (const ConversionPlan& plan : {ample, tight, small}) EXPECT_EQ(plan.lanes, 2u);
  EXPECT_EQ(planOf({1024, 1024, 90}, 4096 * kMiB).window_slices, 90);
}

TEST(ConversionPlan, SourcesThatGiveBoxesHaveNoWindow) {
  const ThreadLimit threads(2);
  const ConversionPlan plan = planOf({1024, 1024, 1000}, 780 * kMiB, ReadOrder::kAnyBox);
  EXPECT_EQ(plan.window_slices, 0);
  EXPECT_EQ(plan.window_bytes, 0u);
  EXPECT_EQ(plan.lanes, 2u);
  EXPECT_EQ(plan.kept_bytes, 268 * 2 * kMiB);  // decoded slices of two layers of bricks
  EXPECT_EQ(plan.total(), 780 * kMiB);         // the rest is for half bricks; the overflow goes to files
  EXPECT_EQ(plan.scratch_bytes, planOf({1024, 1024, 1000}, 4096 * kMiB).parts_bytes - plan.parts_bytes);
}

// Thin volumes have many small bricks, so the index is the largest part of the memory.
TEST(ConversionPlan, TheIndexIsWithinTheBudget) {
  const Extent3 thin = {1, 1, 200'000'000};  // 1.6 million bricks of level 0
  const ConversionPlan plan = planOf(thin, 2048 * kMiB);
  const std::uint64_t bricks = brickCountOf(PlannedSource(thin, ReadOrder::kForward).info(), {});
  EXPECT_GT(bricks, 3'000'000u);
  EXPECT_GE(plan.index_bytes, bricks * kBrickBytes);
  EXPECT_LE(plan.index_bytes, bricks * kBrickBytes + kMiB);  // a few parts wait at a time
  EXPECT_TRUE(plan.sub_ranges_on_disk);
  EXPECT_LE(plan.total(), 2048 * kMiB);
  // A row of bricks has rows of waiting half bricks, not cubes.
  const ConversionPlan row = planOf({3'000'000, 1, 1}, 2048 * kMiB);
  EXPECT_LT(row.total() - row.sub_ranges_bytes, 32 * kMiB);
}

// Tables of bricks are always in memory. A smaller budget fails with an error that names bricks, memory and remedies.
TEST(ConversionPlan, TablesBeyondTheBudgetAreRefused) {
  const Extent3 thin = {1, 1, 200'000'000};
  try {
    planOf(thin, 64 * kMiB);
    ADD_FAILURE() << "tables of 300 MiB are planned within 64 MiB";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBudget);
    const std::string text = error.what();
    for (const char* part : {"bricks", "MiB", "(allowed: 64.0 MiB)", "--memory ", "--brick-size larger than 128"})
      EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
    const std::size_t at = text.find("give --memory ") + 14;
    const std::uint64_t enough = parseBytes(text.substr(at, text.find(',', at) - at));
    EXPECT_LE(planOf(thin, enough).total(), enough);
  }
}

// The ranges of a brick's cells form a cube, even for a volume of a few voxels: 512³ ranges take 2 GiB.
TEST(ConversionPlan, LargeBricksAreWithinTheBudget) {
  ConvertOptions options;
  options.brick_size = 4096;
  EXPECT_THROW(planConversion(PlannedSource({64, 64, 64}, ReadOrder::kAnyBox), options), Error);
  options.brick_size = 512;
  const ConversionPlan plan = planConversion(PlannedSource({64, 64, 64}, ReadOrder::kAnyBox), options);
  EXPECT_GE(plan.lane_bytes, std::uint64_t{4} * 64 * 64 * 64 * sizeof(ValueRange));
}

}  // namespace
}  // namespace kiln::test
