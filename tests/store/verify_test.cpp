// `verify` names exactly the files that differ from the store's metadata. Known because the test damages the files
// itself, or writes a false index or manifest with valid checksums.
#include "store/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "base/file/file.h"
#include "base/thread/parallel.h"
#include "store/store_writer.h"
#include "support/system/expect_error.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr std::uint64_t kPlenty = 1ull << 30;

void write(const fs::path& path, std::span<const std::byte> data) {
  fs::remove(path);
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
  ASSERT_TRUE(out.flush().good()) << path;
}

void write(const fs::path& path, const std::string& text) { write(path, std::as_bytes(std::span(text))); }

class Notes : public Progress {
 public:
  void note(const std::string& sentence) override { notes.push_back(sentence); }
  bool cancelled() const override { return cancel; }
  std::vector<std::string> notes;
  bool cancel = false;
};

struct Findings {
  VerifyReport report;
  std::vector<std::string> sentences;
  std::set<fs::path> files;
};

Findings findingsOf(const fs::path& store, std::uint64_t memory_bytes = kPlenty) {
  Findings out;
  Progress silent;
  out.report = verify(
      StoreReader(store), memory_bytes,
      [&](const Error& damage) {
        EXPECT_TRUE(out.files.insert(damage.path()).second) << "told twice: " << damage.what();
        out.sentences.push_back(damage.what());
      },
      silent);
  EXPECT_EQ(out.report.damaged, out.files.size());
  return out;
}

// Returns the voxels of a block that a store keeps. shape: frame.stored(), x fastest.
std::vector<std::byte> storedVoxels(const BrickBlock& block, const BrickDesc& frame) {
  const VoxelBox box = frame.stored();
  const std::size_t row_bytes = static_cast<std::size_t>(box.extent().x) * sizeOf(block.type);
  std::vector<std::byte> out;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const auto from =
          block.voxels.begin() + block.offsetOf({box.lo.x, y, z}) * static_cast<std::int64_t>(sizeOf(block.type));
      out.insert(out.end(), from, from + static_cast<std::int64_t>(row_bytes));
    }
  }
  return out;
}

class Verify : public ::testing::Test {
 protected:
  void SetUp() override {
    store_ = makeStore(cheese({{40, 20, 21}, VoxelType::i16}, 11, usualRange(VoxelType::i16)), "store", 16);
    const StoreReader reader(store_);
    for (int level = 0; level < reader.index().levels(); ++level) {
      const Extent3& lattice = reader.index().lattice(level);
      for (std::int64_t i = 0; i < lattice.count(); ++i) {
        const BrickKey key{level, brickAt(lattice, i)};
        if (!reader.index().at(key).constant) bricks_.push_back(store_ / brickPath(key));
      }
    }
    largest_ = reader.largestReadBytes();
  }

  // Writes an index and a manifest with consistent checksums after `lie` has changed them.
  template <class Lie>
  void rewrite(Lie&& lie) {
    const StoreReader reader(store_);
    BrickIndex index = reader.index();
    Manifest manifest = reader.manifest();
    lie(index, manifest);
    const std::vector<std::byte> data = index.encode();
    manifest.index_checksum = hashOf(data);
    write(store_ / "index.bin", data);
    write(store_ / "manifest.json", manifestText(manifest));
  }

  void expectOne(const fs::path& file, const std::string& mention) const {
    const Findings found = findingsOf(store_);
    ASSERT_EQ(found.sentences.size(), 1u);
    EXPECT_EQ(*found.files.begin(), store_ / file);
    EXPECT_NE(found.sentences.front().find(mention), std::string::npos) << found.sentences.front();
  }

  fs::path store_;
  std::vector<fs::path> bricks_;
  std::uint64_t largest_ = 0;
};

TEST_F(Verify, AWholeStoreHasNoDamage) {
  const Findings found = findingsOf(store_);
  EXPECT_EQ(found.report.damaged, 0u);
  EXPECT_EQ(found.report.files, bricks_.size() + 2);
}

TEST_F(Verify, NamesEveryDamagedFileWhateverTheThreadsAndTheMemory) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Random random(seed);
    std::set<fs::path> damaged;
    std::map<fs::path, std::vector<std::byte>> whole;
    for (const fs::path& brick : bricks_) {
      if (!random.chance(0.4)) continue;
      damaged.insert(brick);
      std::vector<std::byte> data = whole[brick] = readFile(brick);
      switch (random.between(0, 3)) {
        case 0:
          fs::remove(brick);
          break;
        case 1:
          write(brick, std::span(data).first(data.size() / 2));
          break;
        case 2:
          fs::remove(brick);
          fs::create_directory(brick);
          break;
        default:
          data[static_cast<std::size_t>(random.between(0, static_cast<int>(data.size()) - 1))] ^= std::byte{8};
          write(brick, data);
      }
    }
    const ThreadLimit threads(static_cast<unsigned>(random.between(1, 3)));
    const std::uint64_t index_bytes = StoreReader(store_).index().bytes();
    const Findings found = findingsOf(store_, index_bytes + largest_ * static_cast<unsigned>(random.between(1, 3)));
    EXPECT_EQ(found.files, damaged) << "seed " << seed;
    EXPECT_EQ(found.report.files, bricks_.size() + 2) << "seed " << seed;
    for (const auto& [brick, data] : whole) {
      fs::remove(brick);
      write(brick, data);
    }
  }
  EXPECT_EQ(findingsOf(store_).report.damaged, 0u);
}

TEST_F(Verify, SaysWhatWasFoundAndWhatWasExpected) {
  fs::remove(bricks_[0]);
  const std::vector<std::byte> other = readFile(bricks_[2]);
  write(bricks_[1], other);
  const Findings found = findingsOf(store_);
  const auto said = [&](const std::string& words) {
    return std::any_of(found.sentences.begin(), found.sentences.end(),
                       [&](const std::string& sentence) { return sentence.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(said("is missing, expected "));
  EXPECT_TRUE(said("has " + std::to_string(other.size()) + " bytes, expected ") ||
              said("checksum " + toHex(hashOf(other))));
}

TEST_F(Verify, RangesThatTheVoxelsContradictAreFound) {
  const BrickKey key{0, {1, 1, 0}};
  rewrite([&](BrickIndex& index, Manifest&) { index.at(key).support.lo -= 1; });
  expectOne(brickPath(key), "support range in the index: has [");
  rewrite([&](BrickIndex& index, Manifest&) {
    index.at(key).support.lo += 1;
    index.at(key).core.hi = index.at(key).core.lo;
  });
  expectOne(brickPath(key), "core range in the index: has [");
}

// Known because ranges of coarser levels cover the finer levels: they may be wider than the level's voxels, not
// narrower.
TEST_F(Verify, RangesOfCoarserLevelsMustContain) {
  const BrickKey key{1, {0, 0, 0}};
  rewrite([&](BrickIndex& index, Manifest&) {
    index.at(key).core.hi += 1;
    index.at(key).support.hi += 2;
  });
  EXPECT_EQ(findingsOf(store_).report.damaged, 0u);
  rewrite([&](BrickIndex& index, Manifest&) { index.at(key).support.hi -= 2; });
  expectOne(brickPath(key), "support range in the index: has [");
  rewrite([&](BrickIndex& index, Manifest&) { index.at(key).core.hi = index.at(key).core.lo; });
  expectOne(brickPath(key), "core range in the index: has [");
}

// Known because the store is written with false ranges made by the test.
TEST_F(Verify, CellsThatTheVoxelsContradictAreFound) {
  const auto verified = [&](int level, double wider) {
    Manifest draft = StoreReader(store_).manifest();
    draft.range = {};
    for (LevelInfo& info : draft.levels) info.stored_bricks = info.stored_bytes = 0;
    const StoreReader reader(store_);
    const fs::path other = store_.parent_path() / "other.kiln";
    fs::remove_all(other);
    StoreWriter writer(other, draft, FileSystem::real());
    for (int l = 0; l < reader.index().levels(); ++l) {
      const Extent3& lattice = reader.index().lattice(l);
      for (std::int64_t i = 0; i < lattice.count(); ++i) {
        const BrickKey key{l, brickAt(lattice, i)};
        const BrickBlock block = reader.read(key);
        BrickRanges ranges = rangesOf(block);
        if (key == BrickKey{level, {0, 0, 0}}) ranges.cells[3].hi += wider;
        writer.write(writer.encode(key, storedVoxels(block, reader.frame(key)), ranges));
      }
    }
    writer.finish(draft.histogram, 0);
    return findingsOf(other);
  };
  for (const double wider : {-1.0, 1.0}) {
    const Findings found = verified(0, wider);
    ASSERT_EQ(found.sentences.size(), 1u);
    EXPECT_NE(found.sentences[0].find("bricks/0/0_0_0.vdb: cell 3 of the min-max octree: has ["), std::string::npos);
  }
  const Findings narrower = verified(1, -1);
  ASSERT_EQ(narrower.sentences.size(), 1u);
  EXPECT_NE(narrower.sentences[0].find("bricks/1/0_0_0.vdb: cell 3"), std::string::npos);
}

TEST_F(Verify, AManifestThatTheIndexContradictsIsFound) {
  rewrite([&](BrickIndex&, Manifest& manifest) { manifest.levels[0].stored_bytes += 1; });
  expectOne("manifest.json", "levels[0]");
  rewrite([&](BrickIndex&, Manifest& manifest) {
    manifest.levels[0].stored_bytes -= 1;
    manifest.range.hi += 1;
  });
  expectOne("manifest.json", "range");
}

// At every level, sub-ranges must cover the brick's own voxels.
TEST_F(Verify, ALyingSubRangeIsFound) {
  for (const int level : {0, 1}) {
    rewrite([&](BrickIndex& index, Manifest&) {
      BrickEntry& entry = index.at({level, {0, 0, 0}});
      const std::vector<ValueRange> wide(entry.sub_ranges->count(), entry.support);
      entry.sub_ranges = std::make_shared<const SubRanges>(entry.sub_ranges->along(), wide, entry.support);
    });
    const Findings found = findingsOf(store_);
    ASSERT_EQ(found.sentences.size(), static_cast<std::size_t>(level + 1));
    EXPECT_NE(found.sentences.back().find("range of sub-brick"), std::string::npos) << found.sentences.back();
  }
}

TEST_F(Verify, AConstantBrickOfTwoValuesIsFound) {
  rewrite([&](BrickIndex& index, Manifest& manifest) {
    BrickEntry& entry = index.at({0, {0, 0, 0}});
    entry.constant = true;
    manifest.levels[0].stored_bricks -= 1;
    manifest.levels[0].stored_bytes -= entry.file_bytes;
    entry.file_bytes = 0;
  });
  expectOne("index.bin", "bricks/0/0_0_0.vdb: is constant, but has range");
}

TEST_F(Verify, WhatIsNotTheStoresIsNotedAndIsNoDamage) {
  const auto notes = [&] {
    Notes progress;
    EXPECT_EQ(verify(
                  StoreReader(store_), kPlenty, [](const Error& damage) { FAIL() << damage.what(); }, progress)
                  .damaged,
              0u);
    return progress.notes;
  };
  EXPECT_TRUE(notes().empty());
  write(store_ / "bricks/0/0_0_9.vdb", "x");
  EXPECT_EQ(notes(), std::vector<std::string>{(store_ / "bricks/0/0_0_9.vdb").string() + ": is no part of the store"});
  write(store_ / "thesis.tex", "x");
  ASSERT_EQ(notes().size(), 1u);
  EXPECT_NE(notes().front().find("and 1 more"), std::string::npos);
}

TEST_F(Verify, StopsWhereAsked) {
  Notes progress;
  progress.cancel = true;
  EXPECT_THROW(verify(
                   StoreReader(store_), kPlenty, [](const Error&) {}, progress),
               Error);
}

TEST_F(Verify, TooLittleMemoryIsAnError) {
  expectError([&] { findingsOf(store_, largest_ - 1); }, ErrorCode::kBudget, "");
}

}  // namespace
}  // namespace kiln::test
