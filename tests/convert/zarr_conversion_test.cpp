// Chunks become the store of the same raw voxels. A store never mixes two states of the chunks. Known because the test
// writes the chunks, and changes them itself.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "convert/convert.h"
#include "convert/foreign_cache.h"
#include "convert/plan.h"
#include "ingest/open_source.h"
#include "support/system/impatient_progress.h"
#include "support/volumes/store_files.h"
#include "support/volumes/test_store.h"
#include "support/volumes/zarr_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Three, two and two bricks along the axes.
constexpr Extent3 kZarrDims = {75, 40, 50};

ConvertOptions zarrOptions() {
  ConvertOptions out;
  out.brick_size = 32;
  out.overwrite = true;
  return out;
}

ZarrLayout ofChunks(std::int64_t z, std::int64_t y, std::int64_t x, ZarrVersion version, ZarrCodec codec) {
  ZarrLayout out{.version = version, .codec = codec};
  out.axes = {{'z', z}, {'y', y}, {'x', x}};
  return out;
}

// Converts with the least memory for one lane.
std::map<std::string, std::vector<std::byte>> convertedZarr(VolumeSource& source) {
  const fs::path out = freshDirectory("store") / "volume.kiln";
  ConvertOptions options = zarrOptions();
  const ConversionPlan ample = planConversion(source, options);
  options.memory_bytes = ample.source_bytes + ample.lane_bytes + ample.index_bytes;
  Progress silent;
  EXPECT_LE(convert(source, out, options, silent).buffer_bytes, options.memory_bytes);
  return storeFiles(out);
}

class ZarrConversion : public ::testing::Test {
 protected:
  fs::path folder() const { return files_.directory() / "a.zarr"; }
  void write(const ZarrLayout& layout) const {
    fs::remove_all(folder());
    writeZarr(folder(), volume_, layout);
  }
  void writeChunks() const { write(ofChunks(16, 16, 16, ZarrVersion::kTwo, ZarrCodec::kRaw)); }

  const ForeignFiles files_;
  const ForeignVolume volume_ = randomVolume(kZarrDims, VoxelType::u16, 51);
};

TEST_F(ZarrConversion, EveryVersionGivesTheStoreOfTheRawVoxels) {
  SourceOptions described;
  described.dims = volume_.dims, described.type = volume_.type;
  const auto expected = convertedZarr(*openSource(files_.write("a.raw", volume_.stored(false)), described));
  EXPECT_GT(expected.size(), 12u);
  ZarrLayout shards = ofChunks(10, 16, 16, ZarrVersion::kThree, ZarrCodec::kZstd);
  shards.chunks_in_shard = 3;
  const ZarrLayout layouts[] = {ofChunks(1, 40, 75, ZarrVersion::kTwo, ZarrCodec::kBlosc), shards,
                                ofChunks(33, 20, 64, ZarrVersion::kN5, ZarrCodec::kGzip)};
  for (const ZarrLayout& layout : layouts) {
    write(layout);
    EXPECT_TRUE(convertedZarr(*openSource(folder())) == expected) << static_cast<int>(layout.version);
  }
}

TEST_F(ZarrConversion, InterruptedAndResumed_GivesTheSameStore) {
  writeChunks();
  const auto expected = convertedZarr(*openSource(folder()));
  const fs::path out = freshDirectory("resumed") / "volume.kiln";
  ImpatientProgress impatient(5);
  EXPECT_THROW(convert(*openSource(folder()), out, zarrOptions(), impatient), Error);
  ConvertOptions resuming = zarrOptions();
  resuming.resume = true;
  resuming.overwrite = false;
  Progress silent;
  convert(*openSource(folder()), out, resuming, silent);
  EXPECT_TRUE(storeFiles(out) == expected);
  // A chunk of another time is another source.
  ImpatientProgress again(5);
  EXPECT_THROW(convert(*openSource(folder()), out, zarrOptions(), again), Error);
  writeBelow(folder() / "0.0.0", bytesOf(folder() / "1.0.0"));
  try {
    convert(*openSource(folder()), out, resuming, silent);
    ADD_FAILURE() << "bricks of two states in one store";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("another source, an older state of it"), std::string::npos)
        << error.what();
  }
}

/// Calls change() once some bricks are read.
class ChangingZarr : public VolumeSource {
 public:
  ChangingZarr(std::unique_ptr<VolumeSource> source, std::function<void()> change)
      : source_(std::move(source)), change_(std::move(change)) {}
  const SourceInfo& info() const override { return source_->info(); }
  ReadOrder order() const override { return source_->order(); }
  std::uint64_t decodeBytes() const override { return source_->decodeBytes(); }
  void read(const VoxelBox& box, std::span<std::byte> out) override {
    if (++reads_ == 4) change_();
    source_->read(box, out);
  }

 private:
  const std::unique_ptr<VolumeSource> source_;
  const std::function<void()> change_;
  std::atomic<int> reads_ = 0;
};

TEST_F(ZarrConversion, ChunkChangedMeanwhile_LeavesNoStore) {
  const ThreadLimit one(1);
  const fs::path chunk = folder() / "3.2.4";
  const auto rewrite = [&] {
    const fs::file_time_type before = fs::last_write_time(chunk);
    writeBelow(chunk, std::string(fs::file_size(chunk), '\7'));
    fs::last_write_time(chunk, before);
  };
  const std::pair<const char*, std::function<void()>> changes[] = {
      {"rewritten with the former time", rewrite},
      {"removed", [&] { fs::remove(chunk); }},
      {"added", [&] { writeBelow(folder() / "9.9.9", "more"); }},
      {"renamed", [&] { fs::rename(chunk, folder() / "9.9.9"); }}};
  for (const auto& [what, change] : changes) {
    SCOPED_TRACE(what);
    writeChunks();
    ChangingZarr source(openSource(folder()), change);
    const fs::path out = freshDirectory("changed") / "volume.kiln";
    Progress silent;
    try {
      convert(source, out, zarrOptions(), silent);
      ADD_FAILURE() << "converted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFormat);
      EXPECT_NE(std::string(error.what()).find("was changed while it was converted"), std::string::npos)
          << error.what();
    }
    EXPECT_FALSE(fs::exists(out / "manifest.json"));
  }
}

TEST_F(ZarrConversion, ChunkChangedLater_MakesTheStoreAnew) {
  writeChunks();
  const auto stored = [&](const fs::path& input) {
    Progress silent;
    ConvertOptions options = zarrOptions();
    options.command = "kiln render x";
    return storeFor(kiln::ForeignVolume{input, {}, {}}, options, silent);
  };
  const fs::path store = stored(folder());
  EXPECT_EQ(store, folder().string() + ".kiln");
  const auto first = storeFiles(store);
  const fs::file_time_type written = fs::last_write_time(store / "manifest.json");
  stored(folder() / "");
  EXPECT_EQ(fs::last_write_time(store / "manifest.json"), written) << "made again without a change";
  writeBelow(folder() / "3.2.4", std::string(fs::file_size(folder() / "3.2.4"), '\7'));
  EXPECT_FALSE(isStoreOf(store, openSource(folder())->info()));
  EXPECT_EQ(stored(folder()), store);
  EXPECT_TRUE(isStoreOf(store, openSource(folder())->info()));
  EXPECT_FALSE(storeFiles(store) == first);
}

// A file that vanishes between its listing and a look at it must not end the program.
TEST_F(ZarrConversion, ChunkThatIsADanglingLink_CountsAsMissing) {
  writeChunks();
  fs::create_symlink("nowhere", folder() / "7.7.7");
  convertedZarr(*openSource(folder()));
}

TEST_F(ZarrConversion, StoreInsideItsOwnSource_IsNoChangeOfTheSource) {
  writeChunks();
  const fs::path out = folder() / "out.kiln";
  Progress silent;
  convert(*openSource(folder()), out, zarrOptions(), silent);
  EXPECT_TRUE(isStoreOf(out, openSource(folder())->info()));
}

}  // namespace
}  // namespace kiln::test
