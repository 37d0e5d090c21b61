// The contract of the cache for all read-ahead: bricks equal the store's, each is read once, and the budget holds at
// every moment. A brick that cannot be read is an error only for its own callers.
#include <gtest/gtest.h>

#include <chrono>
#include <exception>
#include <fstream>
#include <new>
#include <set>
#include <thread>
#include <utility>

#include "base/error.h"
#include "cache/brick_cache.h"
#include "store/store_reader.h"
#include "support/system/expect_error.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

class BrickCacheTest : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = makeStore(noise({{48, 48, 48}, VoxelType::u16}, 5, {0, 60000}), "store", 16);
    store_.emplace(path_);
    const Extent3& lattice = store_->index().lattice(0);
    for (std::int64_t i = 0; i < lattice.count(); ++i) keys_.push_back({0, brickAt(lattice, i)});
    for (const BrickKey& key : keys_) largest_ = std::max<std::uint64_t>(largest_, store_->readBytes(key));
  }
  static std::vector<NextBrick> toRead(std::span<const BrickKey> keys) {
    std::vector<NextBrick> out;
    for (const BrickKey& key : keys) out.push_back({{key}});
    return out;
  }
  std::vector<NextBrick> after(std::size_t i, std::size_t count) const {
    return toRead(std::span(keys_).subspan(i + 1, std::min(count, keys_.size() - i - 1)));
  }

  std::filesystem::path path_;
  std::optional<StoreReader> store_;
  std::vector<BrickKey> keys_;
  std::uint64_t largest_ = 0;
};

TEST_F(BrickCacheTest, ReadsABrickOnceHoweverOftenItIsWanted) {
  BrickCache cache(*store_, 1u << 30, 3);
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      cache.announce(toRead(keys_));
      EXPECT_EQ(cache.get(keys_[i])->voxels, store_->read(keys_[i]).voxels);
    }
  }
  cache.settle();
  EXPECT_EQ(cache.counts().reads, keys_.size());
  EXPECT_EQ(cache.counts().unused, 0u);
}

TEST_F(BrickCacheTest, ReadsABrickOnceInAFrameWhateverTheBudget) {
  for (std::uint64_t percent = 100; percent <= 600; percent += 125) {
    BrickCache cache(*store_, largest_ * percent / 100, 2);
    std::vector<NextBrick> first = after(0, 4);
    first.insert(first.begin(), {{keys_[0]}, true});
    cache.announce(first);
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const auto block = cache.get(keys_[i]);
      cache.announce(after(i, 5));
      EXPECT_EQ(block->voxels, store_->read(keys_[i]).voxels);
    }
    cache.settle();
    EXPECT_EQ(cache.counts().reads, keys_.size()) << percent << " % of a brick";
    EXPECT_LE(cache.peakBytes(), cache.budgetBytes());
  }
}

TEST_F(BrickCacheTest, FindsWhatIsInMemoryAndReadsNothing) {
  // Room for three bricks beside a brick being read.
  BrickCache cache(*store_, largest_ + 3 * store_->read(keys_[0]).bytes());
  EXPECT_EQ(cache.find(keys_[0]), nullptr);
  EXPECT_EQ(cache.counts().reads, 0u);
  const BrickBlock* const first = cache.get(keys_[0]).get();
  EXPECT_EQ(cache.find(keys_[0]).get(), first);
  EXPECT_EQ(cache.find(keys_[1]), nullptr);
  cache.get(keys_[1]);
  // A find counts as a use, so the brick is not evicted first.
  for (std::size_t i = 2; i < keys_.size(); ++i) {
    EXPECT_NE(cache.find(keys_[0]), nullptr);
    cache.get(keys_[i]);
  }
  EXPECT_EQ(cache.find(keys_[1]), nullptr);
  EXPECT_EQ(cache.counts().reads, keys_.size());
}

TEST_F(BrickCacheTest, EvictsForWhatTheCallerSetsAside) {
  const std::uint64_t brick = store_->read(keys_[0]).bytes();
  BrickCache cache(*store_, largest_ + 3 * brick);
  for (std::size_t i = 0; i < 4; ++i) cache.get(keys_[i]);
  {
    const BrickCache::Aside aside(cache, largest_ + brick);  // room for two bricks
    EXPECT_EQ(cache.find(keys_[1]), nullptr);
    EXPECT_NE(cache.find(keys_[2]), nullptr);
    EXPECT_NE(cache.find(keys_[3]), nullptr);
  }
  cache.get(keys_[0]);
  EXPECT_NE(cache.find(keys_[2]), nullptr);
}

// Two owners set parts of the budget aside. Known: an owner's change leaves the part of the other, also after an error.
TEST_F(BrickCacheTest, PartsSetAside_addUp) {
  const std::uint64_t brick = store_->read(keys_[0]).bytes();
  BrickCache cache(*store_, largest_ + 3 * brick);
  BrickCache::Aside first(cache);
  EXPECT_EQ(cache.bricksBytes(), cache.budgetBytes());
  for (std::size_t i = 0; i < 4; ++i) cache.get(keys_[i]);
  first.resize(largest_);  // room for three bricks
  EXPECT_THROW(
      {
        const BrickCache::Aside second(cache, 2 * brick);  // room for one
        EXPECT_EQ(cache.bricksBytes(), brick);
        EXPECT_EQ(cache.find(keys_[2]), nullptr);
        EXPECT_NE(cache.find(keys_[3]), nullptr);
        cache.get(keys_[4]);
      },
      Error);
  EXPECT_EQ(cache.bricksBytes(), 3 * brick);
  first.resize(brick);
  EXPECT_EQ(cache.bricksBytes(), largest_ + 2 * brick);
}

TEST_F(BrickCacheTest, FindsNothingThatIsDamaged) {
  std::ofstream(path_ / "bricks/0/0_0_0.vdb", std::ios::binary | std::ios::app) << "more";
  BrickCache cache(*store_, 3 * largest_, 0, [](const Error&) {});
  EXPECT_EQ(cache.get(keys_[0]), nullptr);
  EXPECT_EQ(cache.find(keys_[0]), nullptr);
}

// Known because bricks that become hidden are announced but never requested. Whether or not such a brick was read
// ahead, bricks behind it evict it, and it is never read again.
TEST_F(BrickCacheTest, ReadsNothingAgainThatBecameHidden) {
  BrickCache cache(*store_, largest_, 2);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (i % 3 == 1) continue;
    cache.get(keys_[i]);
    // Gives a reader time to start with earlier announcements.
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    cache.announce(after(i, 5));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  cache.settle();
  EXPECT_LE(cache.counts().reads, keys_.size());
}

// Bricks announced without a read keep more room than the cache has: the brick after them cannot be read ahead.
TEST_F(BrickCacheTest, ReadingAheadThatHasNoRoom_evictsNothing) {
  BrickCache cache(*store_, largest_ + 3 * store_->read(keys_[0]).bytes(), 1);
  for (std::size_t i = 0; i < 4; ++i) cache.get(keys_[i]);
  std::vector<NextBrick> next = after(9, 8);
  for (NextBrick& brick : next) brick.read = false;
  next.push_back({{keys_[20]}});
  cache.announce(next);
  cache.settle();
  for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(cache.holds({keys_[i]})) << i;
  EXPECT_EQ(cache.counts().reads, 4u);
}

// Every other brick is not read ahead, and each is requested: bricks read ahead must not block these requests.
TEST_F(BrickCacheTest, ReadsNothingAgainWhereSomeAreNotReadAhead) {
  BrickCache cache(*store_, largest_, 2);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    cache.get(keys_[i]);
    std::vector<NextBrick> next = after(i, 5);
    for (NextBrick& brick : next) brick.read = brick.brick.key.brick.x != 1;
    cache.announce(next);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  cache.settle();
  EXPECT_EQ(cache.counts().reads, keys_.size());
  EXPECT_EQ(cache.counts().unused, 0u);
}

TEST_F(BrickCacheTest, KeepsTheBudgetWhateverIsAskedAndAnnounced) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed);
    const auto any = [&] { return keys_[static_cast<std::size_t>(random.between(0, 26))]; };
    BrickCache cache(*store_, largest_ * 4, static_cast<unsigned>(random.between(0, 4)));
    std::shared_ptr<const BrickBlock> held;
    for (int step = 0; step < 30; ++step) {
      std::vector<BrickKey> next;
      for (int i = random.between(0, 9); i > 0; --i) next.push_back(any());
      cache.announce(toRead(next));
      const BrickKey key = any();
      const auto block = cache.get(key);
      ASSERT_EQ(block->key, key) << "seed " << seed;
      if (random.chance(0.3)) held = block;
    }
    EXPECT_LE(cache.peakBytes(), cache.budgetBytes()) << "seed " << seed;
  }
}

TEST_F(BrickCacheTest, DamageIsAnErrorWhenAskedForAndNotBefore) {
  const std::filesystem::path file = path_ / "bricks/0/1_1_1.vdb";
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(300).put('\x55').put('\xaa');
  BrickCache cache(*store_, 1u << 30, 2);
  cache.announce(toRead(keys_));
  const BrickKey damaged{0, {1, 1, 1}};
  for (const BrickKey& key : keys_) {
    if (key == damaged) continue;
    EXPECT_EQ(cache.get(key)->key, key);
  }
  for (int again = 0; again < 2; ++again) {
    expectError([&] { cache.get(damaged); }, ErrorCode::kDamaged, "");
  }
}

// Known: a file that is away while bricks are read ahead is read once it is back, and so after an error.
TEST_F(BrickCacheTest, ABrickThatComesBack_isReadAgain) {
  const std::filesystem::path file = path_ / "bricks/0/1_1_1.vdb", away = file.string() + ".away";
  const BrickKey key{0, {1, 1, 1}};
  for (const unsigned readers : {0u, 2u}) {
    BrickCache cache(*store_, 1u << 30, readers);
    std::filesystem::rename(file, away);
    cache.announce(toRead(keys_));
    while (readers > 0 && !cache.holds({keys_.back()})) std::this_thread::yield();
    cache.settle();
    std::filesystem::rename(away, file);
    EXPECT_EQ(cache.get(key)->key, key);
  }
  for (const unsigned readers : {0u, 2u}) {
    BrickCache cache(*store_, 1u << 30, readers);
    std::filesystem::rename(file, away);
    for (int again = 0; again < 2; ++again) expectError([&] { cache.get(key); }, ErrorCode::kNotFound, "");
    std::filesystem::rename(away, file);
    EXPECT_EQ(cache.get(key)->key, key);
    EXPECT_EQ(cache.counts().reads, 1u);
    EXPECT_EQ(cache.counts().hits, 0u);
  }
}

// Known because a file that comes back after the first read is still reported as missing.
TEST_F(BrickCacheTest, DamagedBricksAreSkippedOnceToldAndNotReadAgain) {
  const std::filesystem::path files[] = {path_ / "bricks/0/1_1_1.vdb", path_ / "bricks/0/2_0_1.vdb"};
  for (const std::filesystem::path& file : files) std::filesystem::rename(file, file.string() + ".away");
  const std::set<BrickKey> missing = {{0, {1, 1, 1}}, {0, {2, 0, 1}}};
  for (const unsigned readers : {0u, 3u}) {
    // Room for two bricks: undamaged bricks are evicted.
    std::vector<std::filesystem::path> told;
    BrickCache cache(*store_, largest_ * 2, readers, [&](const Error& error) { told.push_back(error.path()); });
    for (int frame = 0; frame < 3; ++frame) {
      for (std::size_t i = 0; i < keys_.size(); ++i) {
        const auto block = cache.get(keys_[i]);
        cache.announce(after(i, 5));
        EXPECT_EQ(block == nullptr, missing.contains(keys_[i]));
      }
      cache.settle();
      EXPECT_EQ(cache.counts().skipped, 2u * static_cast<unsigned>(frame + 1));
      EXPECT_EQ(told.size(), 2u) << readers << " readers, frame " << frame;
      if (frame > 0) continue;
      for (const std::filesystem::path& file : files) std::filesystem::rename(file.string() + ".away", file);
    }
    EXPECT_EQ(std::set(told.begin(), told.end()), std::set(std::begin(files), std::end(files)));
    EXPECT_LE(cache.peakBytes(), cache.budgetBytes());
    for (const std::filesystem::path& file : files) std::filesystem::rename(file, file.string() + ".away");
  }
}

// A supplier that fails at its first call.
class FailingOnce : public BrickSupplier {
 public:
  FailingOnce(const StoreReader& store, std::exception_ptr failure) : store_(store), failure_(std::move(failure)) {}
  SuppliedBrick supply(const StoredBrick& brick) override {
    if (calls_++ == 0) std::rethrow_exception(failure_);
    return {store_.read(brick.key)};
  }

 private:
  const StoreReader& store_;
  const std::exception_ptr failure_;
  int calls_ = 0;
};

// With skipping, a brick whose file is damaged stays away. A lack of memory and a failed read pass.
TEST_F(BrickCacheTest, SkippedBricks_areReadAgainAfterAPassingFailure) {
  const auto cacheWith = [&](FailingOnce& supplier) {
    return BrickCache(
        {&*store_}, 1u << 30, 0, [](const Error&) {}, &supplier);
  };
  const auto errorOf = [&](ErrorCode code) { return std::make_exception_ptr(Error(code, path_, "", "fails once")); };
  FailingOnce damage(*store_, errorOf(ErrorCode::kDamaged)), read(*store_, errorOf(ErrorCode::kIo)),
      memory(*store_, std::make_exception_ptr(std::bad_alloc()));
  BrickCache damaged = cacheWith(damage), unread = cacheWith(read), full = cacheWith(memory);
  EXPECT_EQ(damaged.get(keys_[0]), nullptr);
  EXPECT_EQ(damaged.get(keys_[0]), nullptr);
  EXPECT_EQ(unread.get(keys_[0]), nullptr);
  EXPECT_NE(unread.get(keys_[0]), nullptr);
  EXPECT_THROW(full.get(keys_[0]), std::bad_alloc);
  EXPECT_NE(full.get(keys_[0]), nullptr);
}

TEST_F(BrickCacheTest, WhatIsHeldIsNotGivenAway) {
  BrickCache cache(*store_, largest_ * 3 / 2, 2);
  std::vector<std::shared_ptr<const BrickBlock>> held;
  cache.announce(toRead(keys_));
  EXPECT_THROW(
      {
        for (const BrickKey& key : keys_) held.push_back(cache.get(key));
      },
      Error);
  EXPECT_GE(held.size(), 1u);
  EXPECT_LE(cache.peakBytes(), cache.budgetBytes());
  held.clear();
  EXPECT_EQ(cache.get(keys_.back())->key, keys_.back());
}

}  // namespace
}  // namespace kiln::test
