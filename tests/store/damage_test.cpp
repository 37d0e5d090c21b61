// A store with damaged files: truncated, flipped, swapped or missing. Opening, reading and drawing gives the picture or
// a kiln::Error with a file of the store. The program never crashes and never draws a different picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/file/file.h"
#include "base/hash.h"
#include "cache/brick_cache.h"
#include "ranks/split_store.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/verify.h"
#include "support/reference/drawing.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

void overwrite(const fs::path& path, std::span<const std::byte> data) {
  fs::remove(path);  // ext4 flushes a file that is truncated and rewritten
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
  ASSERT_TRUE(out.flush().good()) << path;
}

void overwrite(const fs::path& path, const std::string& text) { overwrite(path, std::as_bytes(std::span(text))); }

class StoreDamage : public ::testing::Test {
 protected:
  void SetUp() override {
    volume_ = cheese({{40, 33, 21}, VoxelType::i16, anisotropicAffine()}, 11, usualRange(VoxelType::i16));
    store_ =
        makeStore(volume_, std::string("damage_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    request_.view = resolve(cameraFrom(volume_.geometry, {1, -2, 0.7}, Projection::kPerspective), {64, 64});
    Random random(7);
    request_.transfer_function = randomTransferFunction(random, volume_.range(), volume_.geometry.meanSpacing());
    request_.visibility.method = VisibilityMethod::kNone;
    picture_ = draw(store_, request_);
    for (const auto& entry : fs::recursive_directory_iterator(store_)) {
      if (entry.is_regular_file()) files_.push_back(entry.path());
    }
    std::sort(files_.begin(), files_.end());
    ASSERT_EQ(files_.size(), 2u + 2 * 2 + 1);
  }

  bool samePicture(const Image& image) const {
    return image.rgba.size() == picture_.rgba.size() &&
           std::memcmp(image.rgba.data(), picture_.rgba.data(), image.rgba.size() * sizeof(float)) == 0;
  }

  // Returns the error of opening, reading and drawing, or nothing if the picture is right. Fails for a wrong picture,
  // and for exceptions other than a kiln::Error with a path in the store.
  std::optional<Error> complaint() const {
    try {
      const StoreReader reader(store_);
      for (std::int32_t i = 0; i < 4; ++i) reader.read({0, {i % 2, i / 2, 0}});
      reader.read({1, {0, 0, 0}});
      EXPECT_TRUE(samePicture(draw(store_, request_))) << "another picture";
      return std::nullopt;
    } catch (const Error& error) {
      EXPECT_TRUE(error.path().string().starts_with(store_.string())) << error.what();
      return error;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "not a kiln::Error: " << error.what();
      return std::nullopt;
    }
  }

  void expectFound(const std::string& what) const {
    const std::optional<Error> error = complaint();
    EXPECT_TRUE(error) << what << " was not found";
  }

  void truncate(const fs::path& file, const std::vector<std::size_t>& lengths) {
    const Bytes whole = readFile(file);
    for (const std::size_t length : lengths) {
      overwrite(file, std::span(whole).first(length));
      expectFound(file.string() + " cut to " + std::to_string(length));
    }
    overwrite(file, whole);
    EXPECT_FALSE(complaint()) << "the restored store";
  }

  std::vector<std::size_t> everyLength(const fs::path& file) const {
    std::vector<std::size_t> out(fs::file_size(file));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = i;
    return out;
  }

  void flip(std::uint64_t seed, int flips) {
    std::cout << "seed " << seed << '\n';
    Random random(seed);
    for (int i = 0; i < flips; ++i) {
      const fs::path& file = files_[static_cast<std::size_t>(random.between(0, static_cast<int>(files_.size()) - 1))];
      const Bytes whole = readFile(file);
      Bytes flipped = whole;
      const auto byte = static_cast<std::size_t>(random.between(0, static_cast<int>(whole.size()) - 1));
      const int bit = random.between(0, 7);
      flipped[byte] ^= std::byte(1 << bit);
      overwrite(file, flipped);
      // Every bit of every file is covered by a checksum, so each flip is found, even if invisible in the picture.
      expectFound(file.string() + " byte " + std::to_string(byte) + " bit " + std::to_string(bit));
      overwrite(file, whole);
    }
    EXPECT_FALSE(complaint()) << "the restored store";
  }

  fs::path brick(std::int32_t x, std::int32_t y) const { return store_ / brickPath({0, {x, y, 0}}); }

  DenseVolume volume_;
  fs::path store_;
  FrameRequest request_;
  Image picture_;
  std::vector<fs::path> files_;
};

// Known because a test of equal pictures needs a picture with content.
TEST_F(StoreDamage, ThePictureShowsSomething) {
  EXPECT_FALSE(complaint());
  int seen = 0;
  for (std::size_t at = 3; at < picture_.rgba.size(); at += 4) seen += picture_.rgba[at] > 0;
  EXPECT_GT(seen, 64 * 64 / 10);
}

// Known because a truncated manifest lacks its last member, the checksum, or the line's end after the checksum.
TEST_F(StoreDamage, EveryTruncationOfTheManifestIsFound) {
  truncate(store_ / "manifest.json", everyLength(store_ / "manifest.json"));
}

// Known because the manifest stores the index's length.
TEST_F(StoreDamage, EveryTruncationOfTheIndexIsFound) {
  truncate(store_ / "index.bin", everyLength(store_ / "index.bin"));
}

// Known because the index stores the brick's length.
TEST_F(StoreDamage, TruncationsOfABrickAreFound) {
  std::cout << "seed 21\n";
  Random random(21);
  const int size = static_cast<int>(fs::file_size(brick(1, 0)));
  std::vector<std::size_t> lengths = {0, 1, 20, 57, static_cast<std::size_t>(size) - 1};
  for (int i = 0; i < 295; ++i) lengths.push_back(static_cast<std::size_t>(random.between(0, size - 1)));
  truncate(brick(1, 0), lengths);
}

TEST_F(StoreDamage, NightlyEveryTruncationOfABrickIsFound) { truncate(brick(1, 1), everyLength(brick(1, 1))); }

// Known because every byte of every file is under a checksum.
TEST_F(StoreDamage, FlippedBitsAreFound) { flip(31, 300); }
TEST_F(StoreDamage, NightlyFlippedBitsAreFound) { flip(32, 10000); }

// Known because appended bytes belong to no file of the store.
TEST_F(StoreDamage, BytesBeyondTheEndAreFound) {
  for (const fs::path& file : files_) {
    const Bytes whole = readFile(file);
    Bytes longer = whole;
    longer.push_back(std::byte{'\n'});
    overwrite(file, longer);
    const std::optional<Error> error = complaint();
    ASSERT_TRUE(error) << file;
    EXPECT_EQ(error->code(), ErrorCode::kDamaged) << error->what();
    overwrite(file, whole);
  }
}

// Known because two exchanged whole brick files form a different volume. Inner bricks of noise have equal shapes, and
// some have equal sizes: only the checksum detects these.
TEST_F(StoreDamage, SwappedBricksOfEqualSizeAreFound) {
  const DenseVolume volume = noise({{64, 8, 8}, VoxelType::u8}, 3, {0, 255});
  const fs::path store = makeStore(volume, "damage_swap", 8);
  const StoreReader reader(store);
  int equal_sizes = 0;
  for (std::int32_t i = 1; i < 7; ++i) {
    for (std::int32_t j = i + 1; j < 7; ++j) {
      const fs::path a = store / brickPath({0, {i, 0, 0}}), b = store / brickPath({0, {j, 0, 0}});
      const Bytes was_a = readFile(a), was_b = readFile(b);
      overwrite(a, was_b);
      overwrite(b, was_a);
      for (const std::int32_t x : {i, j}) {
        try {
          reader.read({0, {x, 0, 0}});
          ADD_FAILURE() << "brick " << x << " is another one's";
        } catch (const Error& error) {
          EXPECT_EQ(error.code(), ErrorCode::kDamaged) << error.what();
          if (was_a.size() == was_b.size()) {
            ++equal_sizes;
            EXPECT_NE(std::string(error.what()).find("checksum"), std::string::npos) << error.what();
          }
        }
      }
      overwrite(a, was_a);
      overwrite(b, was_b);
    }
  }
  EXPECT_GT(equal_sizes, 0) << "no two bricks of equal size: the test lost its point";
}

// Known because the files of two noise volumes differ: a read after the replacement gets another store's bytes or a
// missing file. No file is damaged, so the error names the replacement, and no such brick may be drawn or counted as
// damaged.
TEST_F(StoreDamage, AStoreThatIsReplacedWhileItIsRead_IsSaidToBe) {
  const auto noisy = [](std::uint64_t seed) { return noise({{32, 8, 8}, VoxelType::u8}, seed, {0, 255}); };
  const fs::path store = makeStore(noisy(1), "replaced", 8), next = makeStore(noisy(2), "replaced_next", 8);
  const BrickKey key{0, {0, 0, 0}}, gone{0, {1, 0, 0}};
  const StoreReader reader(store);
  BrickCache cache(reader, 1u << 30, 0, [](const Error& error) { ADD_FAILURE() << "skipped: " << error.what(); });
  fs::remove(next / brickPath(gone));
  fs::rename(store, store.string() + ".before");
  fs::rename(next, store);
  Progress silent;
  const std::function<void()> reads[] = {
      [&] { reader.read(key); },
      [&] { reader.read(gone); },
      [&] { reader.readFile(key); },
      [&] { reader.requireUnchanged(); },
      [&] { cache.get(key); },
      [&] {
        verify(
            reader, 1u << 30, [](const Error& damage) { ADD_FAILURE() << damage.what(); }, silent);
      },
      [&] {
        writeStorePart(reader, {{0, 0, 0}, {32, 8, 8}}, store.string() + ".part", silent);
      },
      [&] {
        fs::remove_all(store);
        reader.read(key);
      },
  };
  for (const auto& read : reads) {
    try {
      read();
      ADD_FAILURE() << "bricks of another store were taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kReplaced) << error.what();
      EXPECT_TRUE(std::string(error.what()).starts_with(store.string() + ": the store was replaced")) << error.what();
      EXPECT_TRUE(std::string(error.what()).ends_with("run the command again")) << error.what();
    }
  }
  EXPECT_FALSE(fs::exists(store.string() + ".part"));
}

// Known because the index lists the bricks with files.
TEST_F(StoreDamage, AMissingFileIsNamed) {
  for (const fs::path& file : files_) {
    const Bytes whole = readFile(file);
    fs::remove(file);
    const std::optional<Error> error = complaint();
    ASSERT_TRUE(error) << file;
    EXPECT_NE(std::string(error->what()).find(file.filename().string()), std::string::npos) << error->what();
    overwrite(file, whole);
  }
  EXPECT_FALSE(complaint());
}

TEST_F(StoreDamage, ADirectoryInAFilesPlaceIsNamed) {
  // Known because no directory is a file.
  for (const fs::path& file : files_) {
    const Bytes whole = readFile(file);
    fs::remove(file);
    fs::create_directory(file);
    const std::optional<Error> error = complaint();
    ASSERT_TRUE(error) << file;
    EXPECT_EQ(error->path(), file);
    fs::remove(file);
    overwrite(file, whole);
  }
}

// Known because without gradients a sample depends only on its own value. A skipped brick therefore equals a brick of a
// value that the transfer function hides. (The pixel lattice would interpolate between the brick and its neighbours,
// whose aprons hold its voxels.)
TEST_F(StoreDamage, ASkippedBrickIsDrawnAsNothing) {
  const ValueRange range = volume_.range();
  // in a brick that stays, so that the value range is equal without the other bricks
  volume_.set(39, 32, 20, range.hi);
  store_ = makeStore(volume_, "damage_with");
  request_.transfer_function = {0, {{range.lo, {1, 1, 1}, 0}, {range.hi, {1, 0.5, 0}, 0.9}}};
  request_.shading.phong = false;
  request_.lattice = Lattice::kVoxel;
  for (const std::int32_t x : {0, 1}) {
    DenseVolume without = volume_;
    for (std::int64_t k = 0; k < 21; ++k) {
      for (std::int64_t j = 0; j < 32; ++j) {
        for (std::int64_t i = 32 * x; i < std::min<std::int64_t>(32 * x + 32, 40); ++i) without.set(i, j, k, range.lo);
      }
    }
    ASSERT_EQ(without.range(), range);
    picture_ = draw(makeStore(without, "damage_without"), request_);
    const Bytes whole = readFile(brick(x, 0));
    overwrite(brick(x, 0), std::span(whole).first(whole.size() / 2));
    const StoreReader reader(store_);
    std::vector<fs::path> told;
    BrickCache cache(reader, 1u << 30, 2, [&](const Error& damage) { told.push_back(damage.path()); });
    Progress silent;
    FrameStatistics statistics;
    EXPECT_TRUE(samePicture(renderFrame(cache, request_, silent, statistics))) << "brick " << x;
    EXPECT_EQ(told, std::vector<fs::path>{brick(x, 0)});
    EXPECT_EQ(statistics.bricks_damaged, 1u);
    overwrite(brick(x, 0), whole);
  }
}

// Known because the manifest alone is no volume.
TEST_F(StoreDamage, AManifestWithoutBricksIsFound) {
  fs::remove_all(store_ / "bricks");
  expectFound("no bricks");
  fs::remove(store_ / "index.bin");
  expectFound("nothing but the manifest");
}

// Known because another volume's store is whole in itself, but this store's manifest stores the checksum of its own
// index.
TEST_F(StoreDamage, AnotherStoresIndexIsFound) {
  const fs::path other = makeStore(noise({{40, 33, 21}, VoxelType::i16}, 4, {0, 9}), "damage_other_index");
  ASSERT_EQ(fs::file_size(other / "index.bin"), fs::file_size(store_ / "index.bin"));
  overwrite(store_ / "index.bin", readFile(other / "index.bin"));
  const std::optional<Error> error = complaint();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code(), ErrorCode::kDamaged);
}

// Known because index.bin has 64 bytes per brick. A manifest with more bricks than the index has room for is refused
// before an allocation of the claimed size, even with a valid checksum.
TEST_F(StoreDamage, AManifestThatPromisesTooMuchIsRefused) {
  using Json = nlohmann::ordered_json;
  const Json whole = Json::parse(readTextFile(store_ / "manifest.json"));
  const Json huge = Json::array({2147483647, 2147483647, 2147483647});
  for (const std::int64_t brick_size : {8, 32, 1 << 20}) {
    Json json = whole;
    json["brickSize"] = brick_size;
    json["dimensions"] = json["levels"][0]["dimensions"] = huge;
    const std::int64_t bricks = (2147483647ll + brick_size - 1) / brick_size;
    json["levels"][0]["bricks"] = Json::array({bricks, bricks, bricks});
    overwrite(store_ / "manifest.json", restamped(json.dump(1)));
    expectFound("bricks of " + std::to_string(brick_size));
  }
  for (const std::uint64_t bytes : {0ull, 1ull, 9223372036854775807ull}) {
    Json json = whole;
    json["index"]["bytes"] = bytes;
    overwrite(store_ / "manifest.json", restamped(json.dump(1)));
    expectFound("an index of " + std::to_string(bytes) + " bytes");
  }
}

}  // namespace
}  // namespace kiln::test
