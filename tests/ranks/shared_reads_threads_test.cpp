// Ranks that share reads get the bytes of the file on disk with fewer reads, for every memory size, request order and
// read error. Known because every fetched file is compared with the file on disk, and every error with the error of a
// local read.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <random>
#include <set>
#include <thread>

#include "base/error.h"
#include "ranks/shared_reads.h"
#include "store/store_writer.h"
#include "support/system/thread_ranks.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class SharedReadsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = makeStore(noise({{48, 40, 33}, VoxelType::u16}, 5, {0, 60000}), "store", 16);
    const StoreReader store(path_);
    for (int level = 0; level < store.index().levels(); ++level) {
      const Extent3& lattice = store.index().lattice(level);
      for (std::int64_t i = 0; i < lattice.count(); ++i) keys_.push_back({level, brickAt(lattice, i)});
    }
    std::erase_if(keys_, [&](const BrickKey& key) { return store.index().at(key).constant; });
    for (const BrickKey& key : keys_) bytes_ += store.index().at(key).file_bytes;
    largest_ = store.largestFileBytes();
  }

  // Fetches each key once on each of `threads` threads, in a random order per thread.
  void fetchAll(SharedReads& shared, const StoreReader& store, int seed, int threads) const {
    std::vector<std::jthread> running;
    for (int t = 0; t < threads; ++t) {
      running.emplace_back([&, t] {
        std::vector<BrickKey> keys = keys_;
        std::shuffle(keys.begin(), keys.end(), std::mt19937(static_cast<unsigned>(16 * seed + t)));
        for (const BrickKey& key : keys) expectSame(shared, store, key);
      });
    }
  }
  static void expectSame(SharedReads& shared, const StoreReader& store, const BrickKey& key) {
    std::string here, there;
    std::vector<std::byte> expected;
    BrickFile found;
    try {
      expected = store.readFile(key);
    } catch (const Error& error) {
      here = error.what();
    }
    try {
      found = shared.fetch(store, key);
    } catch (const Error& error) {
      there = error.what();
    }
    EXPECT_EQ(here, there);
    ASSERT_EQ(found.bytes != nullptr, here.empty());
    if (found.bytes) {
      EXPECT_TRUE(*found.bytes == expected) << brickPath(key);
    }
  }

  // Returns the counts of all ranks after each has fetched all keys. `memory` is the cache size per rank; a rank with 0
  // does not open the store.
  std::vector<SharedReadCounts> fetchedBy(int ranks, const std::vector<std::uint64_t>& memory, int threads) {
    std::vector<SharedReadCounts> out(static_cast<std::size_t>(ranks));
    runRanks(ranks, [&](Ranks& own) {
      const auto rank = static_cast<std::size_t>(own.rank());
      const StoreReader store(path_);
      SharedReads shared(own);
      {
        const OpenedForRanks opened(&shared, {&store}, memory[rank % memory.size()]);
        own.barrier();
        if (opened.supplier() != nullptr) fetchAll(shared, store, own.rank(), threads);
        shared.finish();
        // After finish() no rank answers requests, and fetches still work.
        if (opened.supplier() != nullptr) expectSame(shared, store, keys_.front());
      }
      out[rank] = shared.counts();
    });
    return out;
  }

  fs::path path_;
  std::vector<BrickKey> keys_;
  std::uint64_t bytes_ = 0, largest_ = 0;
};

TEST_F(SharedReadsTest, EachFileIsReadOnceWhereThereIsMemory) {
  for (const int ranks : {2, 5}) {
    SharedReadCounts sum;
    for (const SharedReadCounts& rank : fetchedBy(ranks, {8 * bytes_}, 3)) {
      sum.read += rank.read, sum.read_bytes += rank.read_bytes;
      sum.received += rank.received, sum.received_bytes += rank.received_bytes;
      sum.sent += rank.sent, sum.sent_bytes += rank.sent_bytes;
    }
    // After finish(), each rank other than the key's home reads one more file.
    EXPECT_LE(sum.read, keys_.size() + static_cast<std::size_t>(ranks));
    EXPECT_GE(sum.read, keys_.size());
    EXPECT_EQ(sum.received, 3 * keys_.size() * static_cast<std::size_t>(ranks - 1));
    EXPECT_EQ(sum.received, sum.sent);
    EXPECT_EQ(sum.received_bytes, sum.sent_bytes);
    EXPECT_EQ(sum.received_bytes, 3 * bytes_ * static_cast<std::size_t>(ranks - 1));
  }
}

TEST_F(SharedReadsTest, WithLittleMemoryFilesAreReadAgain) {
  const auto ranks = fetchedBy(3, {4 * largest_}, 4);
  std::uint64_t read = 0;
  for (const SharedReadCounts& rank : ranks) read += rank.read;
  EXPECT_GT(read, keys_.size());
}

// A rank without the store open: in a time series ranks draw different volumes, or a rank has no memory left.
TEST_F(SharedReadsTest, WhoHasTheStoreNotOpenAnswersThatItHasNone) {
  const auto ranks = fetchedBy(3, {8 * bytes_, 0, 8 * bytes_}, 2);
  EXPECT_EQ(ranks[1].sent, 0u);
  EXPECT_GT(ranks[0].sent, 0u);
  EXPECT_GT(ranks[0].received, 0u);
}

TEST_F(SharedReadsTest, ErrorsAreThoseOfReadingItOneself) {
  fs::remove(path_ / brickPath(keys_[3]));
  fs::resize_file(path_ / brickPath(keys_[5]), 40);
  std::fstream(path_ / brickPath(keys_[8]), std::ios::in | std::ios::out).seekp(100).put('x').put('y');
  for (const SharedReadCounts& rank : fetchedBy(3, {8 * bytes_}, 2)) EXPECT_GT(rank.received, 0u);
}

// A failed rank ends the waiting of all other ranks, and the job fails with the error of this rank.
TEST_F(SharedReadsTest, ARankThatFailsEndsTheOthers) {
  for (int failing = 0; failing < 3; ++failing) {
    try {
      runRanks(3, [&](Ranks& own) {
        const StoreReader store(path_);
        SharedReads shared(own);
        const OpenedForRanks opened(&shared, {&store}, 8 * bytes_);
        own.barrier();
        if (own.rank() == failing) {
          shared.abandon();
          throw Error(ErrorCode::kCancelled, "this one");
        }
        for (int round = 0; round < 2; ++round) fetchAll(shared, store, round, 2);
        own.barrier();
      });
      FAIL();
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(), "this one");
    }
  }
}

TEST_F(SharedReadsTest, WhatNobodyElseIsLikelyToNeedMakesRoomFirst) {
  const StoreReader store(path_);
  EncodedBricks files(3 * largest_);
  const auto from_disk = [&](std::size_t i, bool likely) { return files.get(store, {keys_[i]}, likely).from_disk; };
  EXPECT_TRUE(from_disk(0, true));
  for (std::size_t i = 1; i < keys_.size(); ++i) EXPECT_TRUE(from_disk(i, false));
  EXPECT_FALSE(from_disk(0, true));
  // Among files that are likely to be requested again, the most recent request stays in memory.
  for (std::size_t i = 1; i < keys_.size(); ++i) from_disk(i, true);
  EXPECT_FALSE(from_disk(keys_.size() - 1, true));
  EXPECT_TRUE(from_disk(0, true));
}

TEST(SharedReadsMemory, IsAShareOfWhatIsLeftOrNothing) {
  const std::uint64_t mib = 1 << 20;
  EXPECT_EQ(SharedReads::shareOf(2048 * mib, 1800 * mib, 3 * mib), 256 * mib);
  EXPECT_EQ(SharedReads::shareOf(2048 * mib, 400 * mib, 3 * mib), 100 * mib);
  EXPECT_EQ(SharedReads::shareOf(64 * mib, 30 * mib, 3 * mib), 0u);
}

}  // namespace
}  // namespace kiln::test
