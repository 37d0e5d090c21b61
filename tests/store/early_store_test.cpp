// Stores of early writers, before voxels of 8 and 16 bits became Int32 on disk: float grids, saved as half if every
// value is representable (FORMAT.md, brick files). Known because a current store holds an equal volume: readers,
// `verify` and pictures must give equal bits for both.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <tuple>

#include "base/file/file.h"
#include "base/hash.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "support/files/vdb_files.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/system/text_of.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

template <class F>
void forEachBrick(const BrickIndex& index, F&& f) {
  for (int level = 0; level < index.levels(); ++level) {
    const Extent3& n = index.lattice(level);
    for (std::int32_t z = 0; z < n.z; ++z) {
      for (std::int32_t y = 0; y < n.y; ++y) {
        for (std::int32_t x = 0; x < n.x; ++x) f(BrickKey{level, {x, y, z}});
      }
    }
  }
}

// Rewrites every brick of the store as an early writer did, and updates the index and the manifest.
void makeEarly(const fs::path& path, bool half) {
  const StoreReader store(path);
  Manifest manifest = store.manifest();
  BrickIndex index = store.index();
  for (LevelInfo& level : manifest.levels) level.stored_bytes = 0;
  forEachBrick(store.index(), [&](const BrickKey& key) {
    BrickEntry& entry = index.at(key);
    if (entry.constant) return;
    const fs::path file = path / brickPath(key);
    const std::vector<std::byte> early = writtenAsFloat(file, half);
    writeText(file, textOf(early));
    entry.file_bytes = early.size();
    entry.checksum = hashOf(early);
    manifest.levels[static_cast<std::size_t>(key.level)].stored_bytes += early.size();
    const DirectGrid grid(file, "density");
    EXPECT_EQ(grid.type(), "float");
    EXPECT_EQ(grid.savedAsHalf(), half);
  });
  const std::vector<std::byte> encoded = index.encode();
  manifest.index_checksum = hashOf(encoded);
  writeText(path / "index.bin", textOf(encoded));
  writeText(path / "manifest.json", manifestText(manifest));
}

void expectSameBrick(const BrickBlock& early, const BrickBlock& today) {
  EXPECT_EQ(early.type, today.type);
  EXPECT_TRUE(early.voxels == today.voxels);
  ASSERT_EQ(early.octree.depth(), today.octree.depth());
  for (int level = 0; level < today.octree.depth(); ++level) {
    const int n = today.octree.edge(level);
    for (int i = 0; i < n * n * n; ++i) {
      const int x = i % n, y = i / n % n, z = i / n / n;
      EXPECT_EQ(early.octree.at(level, x, y, z), today.octree.at(level, x, y, z));
    }
  }
  const int n = today.supports.edge();
  for (int i = 0; i < n * n * n; ++i) {
    const int x = i % n, y = i / n % n, z = i / n / n;
    EXPECT_EQ(early.supports.at(x, y, z), today.supports.at(x, y, z));
  }
}

// `half`: all values of the type's volume below are representable as half.
using EarlyCase = std::tuple<VoxelType, bool>;
class EarlyStore : public ::testing::TestWithParam<EarlyCase> {};

TEST_P(EarlyStore, IsReadAndDrawnAsOneOfToday) {
  const auto [type, half] = GetParam();
  // A half holds whole numbers up to 2048; the usual CT numbers go beyond.
  const ValueRange range = type == VoxelType::i16 && half ? ValueRange{-2048, 2048} : usualRange(type);
  DenseVolume volume = cheese({{29, 21, 13}, type, anisotropicAffine()}, 11, range);
  volume.set(17, 3, 12, range.lo);
  volume.set(2, 20, 0, range.hi);
  const fs::path today_path = makeStore(volume, "today", 16), early_path = makeStore(volume, "early", 16);
  makeEarly(early_path, half);
  const StoreReader today(today_path), early(early_path);
  ASSERT_GT(today.index().levels(), 1);
  EXPECT_NE(early.manifest().index_checksum, today.manifest().index_checksum);
  EXPECT_EQ(wholeFiles(early_path), wholeFiles(today_path));
  forEachBrick(today.index(), [&](const BrickKey& key) {
    SCOPED_TRACE(brickPath(key));
    expectSameBrick(early.read(key), today.read(key));
  });

  Random random(7);
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {1, -2, 0.7}, Projection::kPerspective), {64, 64});
  request.transfer_function = randomTransferFunction(random, volume.range(), volume.geometry.meanSpacing());
  for (const Lattice lattice : kLattices) {
    request.lattice = lattice;
    for (const int level : {0, 1}) {
      request.level = level;
      FrameStatistics statistics;
      const Image picture = draw(today_path, request, 1ull << 30, &statistics);
      EXPECT_GT(statistics.voxels_splats, 100u) << "a picture of something";
      EXPECT_TRUE(equalBits(draw(early_path, request), picture)) << nameOf(lattice) << " of level " << level;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Types, EarlyStore,
                         ::testing::Combine(::testing::Values(VoxelType::u8, VoxelType::i16), ::testing::Bool()),
                         [](const ::testing::TestParamInfo<EarlyCase>& info) {
                           return std::string(nameOf(std::get<0>(info.param))) +
                                  (std::get<1>(info.param) ? "half" : "float");
                         });

}  // namespace
}  // namespace kiln::test
