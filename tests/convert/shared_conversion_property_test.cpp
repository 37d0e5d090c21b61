// Conversions shared by several ranks. Known because a single process makes the same volume's store: all files have
// equal bytes for every number of ranks, memory, brick size, read order and earlier failure.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/thread/parallel.h"
#include "convert/plan.h"
#include "convert/pyramid/brick_shares.h"
#include "support/system/faulty_file_system.h"
#include "support/system/thread_ranks.h"
#include "support/volumes/forward_source.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Skips syncing, which would wait for all processes' writes; no test here covers a power cut.
class UnsyncedDisk : public FileSystem {
 public:
  void syncFile(const fs::path& /*path*/) override {}
  void syncAll(const fs::path& /*path*/) override {}
};

struct Case {
  const char* name;
  DenseVolume volume;
  std::int64_t brick_size;
  bool forward = false;
  bool parts_in_files = false;
  bool labels = false;
};

// Empty space (bricks without a file), NaNs, both zeros, odd sizes.
DenseVolume holes() {
  DenseVolume out = cheese({{43, 21, 34}, VoxelType::f32, obliqueAffine()}, 5, {-1, 1});
  for (std::int64_t z = 0; z < 34; ++z) {
    for (std::int64_t y = 0; y < 21; ++y) {
      for (std::int64_t x = 0; x < 43; ++x) {
        if (z < 17) out.set(x, y, z, y % 2 == 0 ? 0.0 : -0.0);
        if (x > 34 && z > 20) out.set(x, y, z, std::nan(""));
      }
    }
  }
  return out;
}

std::vector<Case> cases() {
  return {{"small bricks", cheese({{40, 33, 26}, VoxelType::i16}, 1, usualRange(VoxelType::i16)), 8},
          {"anisotropic, in files", head({{60, 40, 20}, VoxelType::u8, anisotropicAffine()}, usualRange(VoxelType::u8)),
           16, false, true},
          {"holes", holes(), 8},
          {"a stream", cheese({{26, 20, 42}, VoxelType::u16}, 2, usualRange(VoxelType::u16)), 8, true},
          {"labels", noise({{34, 27, 20}, VoxelType::i32, anisotropicAffine()}, 3, {0, 3}), 8, false, true, true},
          {"one brick", cheese({{9, 9, 9}, VoxelType::u8}, 2, usualRange(VoxelType::u8)), 16}};
}

std::unique_ptr<VolumeSource> sourceOf(const Case& c) {
  if (c.forward) return std::make_unique<ForwardSource>(c.volume);
  return std::make_unique<DenseSource>(c.volume);
}

ConvertOptions optionsOf(const Case& c, Ranks* ranks) {
  ConvertOptions out;
  out.brick_size = c.brick_size;
  out.ranks = ranks;
  out.labels = c.labels;
  if (c.parts_in_files) {
    const ConversionPlan ample = planConversion(*sourceOf(c), out);
    out.memory_bytes = ample.total() - ample.parts_bytes - ample.sub_ranges_bytes;
    EXPECT_TRUE(planConversion(*sourceOf(c), out).sub_ranges_on_disk);
  }
  return out;
}

using Files = std::map<std::string, std::vector<std::byte>>;

Files madeByOne(const Case& c) {
  const fs::path directory = freshDirectory("shared_one");
  Progress silent;
  UnsyncedDisk disk;
  ConvertOptions options = optionsOf(c, nullptr);
  options.disk = &disk;
  convert(*sourceOf(c), directory / "volume.kiln", options, silent);
  return filesOf(directory);
}

struct RankWorld {
  FileSystem* broken = nullptr;  // the disk of
  int broken_rank = 0;
  bool resume = false;
};

ConvertReport convertBy(int ranks, const Case& c, const fs::path& out, const RankWorld& world = {}) {
  ConvertReport report;
  runRanks(ranks, [&](Ranks& own) {
    Progress silent;
    ConvertOptions options = optionsOf(c, &own);
    options.resume = world.resume;
    UnsyncedDisk disk;
    const bool breaks = world.broken != nullptr && own.rank() == world.broken_rank;
    options.disk = breaks ? world.broken : &disk;
    const ConvertReport found = convert(*sourceOf(c), out, options, silent);
    if (own.first()) report = found;
  });
  return report;
}

TEST(SharedConversion, HasTheBytesOfOneProcess) {
  for (const Case& c : cases()) {
    const Files expected = madeByOne(c);
    for (const int ranks : {2, 5}) {
      SCOPED_TRACE(fmt::format("{}, {} ranks", c.name, ranks));
      const fs::path directory = freshDirectory("shared_many");
      const ConvertReport report = convertBy(ranks, c, directory / "volume.kiln");
      EXPECT_EQ(filesOf(directory), expected);
      EXPECT_EQ(std::distance(fs::directory_iterator(directory), {}), 1) << "something was left beside the store";
      ASSERT_EQ(report.ranks.size(), static_cast<std::size_t>(ranks));
      std::uint64_t bricks = 0, bytes = 0;
      for (const RankConversion& rank : report.ranks) {
        bricks += rank.bricks;
        bytes += rank.written_bytes;
      }
      EXPECT_EQ(bricks, report.bricks);
      EXPECT_EQ(bytes, report.stored_bytes);
    }
  }
}

bool opens(const fs::path& path) { return fs::exists(path / "manifest.json"); }

// The n-th change of a rank's disk fails, for each rank; all other ranks end. Then new ranks or a single process
// resume.
TEST(SharedConversion, GoesOnAfterARankHasFailed) {
  const std::vector<Case> all = cases();
  int failed = 0;
  for (const std::size_t which : {0u, 3u}) {
    const Case& c = all[which];
    const Files expected = madeByOne(c);
    for (const int rank : {0, 2}) {
      for (const std::uint64_t after : {3u, 20u, 50u}) {
        SCOPED_TRACE(fmt::format("{}: change {} of rank {} fails", c.name, after, rank));
        const fs::path directory = freshDirectory("shared_failed");
        FaultyFileSystem broken({after, ENOSPC, true, true});
        const RankWorld world{&broken, rank};
        bool ended = false;
        try {
          convertBy(3, c, directory / "volume.kiln", world);
        } catch (const Error& error) {
          ended = true;
          EXPECT_EQ(error.code(), ErrorCode::kNoSpace) << error.what();
        }
        EXPECT_EQ(ended, broken.failed());
        EXPECT_EQ(opens(directory / "volume.kiln"), !ended);
        failed += ended ? 1 : 0;
        RankWorld again;
        again.resume = true;
        // Before the first rank has written a journal, there is neither anything to resume nor an obstacle.
        if (after % 2 == 0) {
          convertBy(after % 4 == 0 ? 4 : 2, c, directory / "volume.kiln", again);
        } else {
          ConvertOptions options = optionsOf(c, nullptr);
          options.resume = true;
          Progress silent;
          UnsyncedDisk disk;
          options.disk = &disk;
          convert(*sourceOf(c), directory / "volume.kiln", options, silent);
        }
        EXPECT_EQ(filesOf(directory), expected);
      }
    }
  }
  EXPECT_GE(failed, 8) << "too few of the twelve were long enough";
}

// Known because of two volumes no store can be made.
TEST(SharedConversion, RefusesRanksThatReadDifferentVolumes) {
  const fs::path out = freshDirectory("shared_different") / "volume.kiln";
  std::vector<Case> all = cases();
  try {
    runRanks(3, [&](Ranks& ranks) {
      const Case& c = all[ranks.rank() == 2 ? 2 : 0];
      Progress silent;
      ConvertOptions options = optionsOf(all[0], &ranks);
      convert(*sourceOf(c), out, options, silent);
    });
    FAIL() << "converted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFormat);
    EXPECT_NE(std::string(error.what()).find("rank 2 on "), std::string::npos) << error.what();
  }
  EXPECT_FALSE(fs::exists(out));
}

TEST(BrickShares, GiveEachBrickToOneRank) {
  for (const bool in_order : {false, true}) {
    for (const std::int64_t bricks : {0, 1, 7, 1000}) {
      std::vector<std::int64_t> places(static_cast<std::size_t>(bricks));
      std::iota(places.begin(), places.end(), 100);
      std::mutex mutex;
      std::multiset<std::int64_t> taken;
      runRanks(4, [&](Ranks& ranks) {
        BrickShares shares(ranks, places, 32, in_order);
        std::int64_t last = 0;
        // The last rank starts when the others have finished.
        if (ranks.rank() == 3) ranks.barrier();
        while (const std::optional<std::int64_t> brick = shares.next()) {
          if (in_order) {
            EXPECT_GT(*brick, last);
          }
          last = *brick;
          const std::scoped_lock lock(mutex);
          taken.insert(*brick);
        }
        if (ranks.rank() != 3) ranks.barrier();
        ranks.barrier();
      });
      EXPECT_EQ(std::vector<std::int64_t>(taken.begin(), taken.end()), places) << in_order;
    }
  }
}

}  // namespace
}  // namespace kiln::test
