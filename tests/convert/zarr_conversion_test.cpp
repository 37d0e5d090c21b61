// Chunks become the store of the same raw voxels. A store never mixes two states of the chunks. Known because the test
// writes the chunks, and changes them itself.
#include <gtest/gtest.h>

#include <functional>

#include "base/thread/parallel.h"
#include "convert/foreign_cache.h"
#include "convert/plan.h"
#include "convert/store_of_source.h"
#include "ingest/bytes/block_cache.h"
#include "ingest/open_source.h"
#include "store/manifest/read_manifest.h"
#include "support/files/zarr_files.h"
#include "support/system/impatient_progress.h"
#include "support/volumes/conversions.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Three, two and two bricks along the axes.
constexpr Extent3 kZarrDims = {75, 40, 50};

ZarrLayout ofChunks(std::int64_t z, std::int64_t y, std::int64_t x, ZarrVersion version, ZarrCodec codec) {
  ZarrLayout out{.version = version, .codec = codec};
  out.axes = {{'z', z}, {'y', y}, {'x', x}};
  return out;
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
  const auto expected = convertedInOneLane(*openSource(files_.write("a.raw", volume_.stored(false)), described));
  EXPECT_GT(expected.size(), 12u);
  ZarrLayout shards = ofChunks(10, 16, 16, ZarrVersion::kThree, ZarrCodec::kZstd);
  shards.chunks_in_shard = 3;
  const ZarrLayout layouts[] = {ofChunks(1, 40, 75, ZarrVersion::kTwo, ZarrCodec::kBlosc), shards,
                                ofChunks(33, 20, 64, ZarrVersion::kN5, ZarrCodec::kGzip)};
  for (const ZarrLayout& layout : layouts) {
    write(layout);
    EXPECT_TRUE(convertedInOneLane(*openSource(folder())) == expected) << static_cast<int>(layout.version);
  }
}

TEST_F(ZarrConversion, InterruptedAndResumed_GivesTheSameStore) {
  writeChunks();
  const auto expected = convertedInOneLane(*openSource(folder()));
  const fs::path out = freshDirectory("resumed") / "volume.kiln";
  ImpatientProgress impatient(5);
  EXPECT_THROW(convert(*openSource(folder()), out, smallBricks(), impatient), Error);
  ConvertOptions resuming = smallBricks();
  resuming.resume = true;
  resuming.overwrite = false;
  Progress silent;
  convert(*openSource(folder()), out, resuming, silent);
  EXPECT_TRUE(storeFiles(out) == expected);
  // A chunk of another time is another source.
  ImpatientProgress again(5);
  EXPECT_THROW(convert(*openSource(folder()), out, smallBricks(), again), Error);
  writeBelow(folder() / "0.0.0", bytesOf(folder() / "1.0.0"));
  expectError([&] { convert(*openSource(folder()), out, resuming, silent); }, ErrorCode::kExists,
              "another source, an older state of it");
}

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
    ChangingSource source(openSource(folder()), 4, change);
    const fs::path out = freshDirectory("changed") / "volume.kiln";
    Progress silent;
    expectError([&] { convert(source, out, smallBricks(), silent); }, ErrorCode::kFormat,
                "was changed while it was converted");
    EXPECT_FALSE(fs::exists(out / "manifest.json"));
  }
}

TEST_F(ZarrConversion, ChunkChangedLater_MakesTheStoreAnew) {
  writeChunks();
  const auto stored = [&](const fs::path& input) {
    Progress silent;
    ConvertOptions options = smallBricks();
    options.command = "kiln render x";
    return storeFor(kiln::ForeignVolume{input, {}, {}}, options, silent);
  };
  const fs::path store = stored(folder());
  EXPECT_EQ(store, folder().string() + ".kiln");
  const auto first = filesOf(store);
  const fs::file_time_type written = fs::last_write_time(store / "manifest.json");
  stored(folder() / "");
  EXPECT_EQ(fs::last_write_time(store / "manifest.json"), written) << "made again without a change";
  writeBelow(folder() / "3.2.4", std::string(fs::file_size(folder() / "3.2.4"), '\7'));
  EXPECT_FALSE(isStoreOf(store, openSource(folder())->info()));
  EXPECT_EQ(stored(folder()), store);
  EXPECT_TRUE(isStoreOf(store, openSource(folder())->info()));
  EXPECT_FALSE(filesOf(store) == first);
}

// A file that vanishes between its listing and a look at it must not end the program.
TEST_F(ZarrConversion, ChunkThatIsADanglingLink_CountsAsMissing) {
  writeChunks();
  const auto expected = convertedInOneLane(*openSource(folder()));
  fs::create_symlink("nowhere", folder() / "7.7.7");
  EXPECT_TRUE(convertedInOneLane(*openSource(folder())) == expected);
}

TEST_F(ZarrConversion, StoreInsideItsOwnSource_IsNoChangeOfTheSource) {
  writeChunks();
  const fs::path out = folder() / "out.kiln";
  Progress silent;
  convert(*openSource(folder()), out, smallBricks(), silent);
  EXPECT_TRUE(isStoreOf(out, openSource(folder())->info()));
}

// Known from FORMAT.md: stores without a look keep the earlier format.
TEST_F(ZarrConversion, LookOfTheSource_isInTheStore) {
  const fs::path image = files_.directory() / "image.zarr";
  writeZarr(image / "0", volume_, {});
  files_.write("image.zarr/.zgroup", R"({"zarr_format": 2})");
  const std::string multiscales = R"("multiscales": [{"axes": ["z", "y", "x"], "datasets": [{"path": "0"}]}])";
  const auto manifestOf = [&](const std::string& more) {
    files_.write("image.zarr/.zattrs", "{" + multiscales + more + "}");
    const fs::path out = freshDirectory("look") / "volume.kiln";
    Progress silent;
    convert(*openSource(image), out, smallBricks(), silent);
    return readManifest(out);
  };
  EXPECT_EQ(manifestOf("").format, kFormatWithoutLook);
  const Manifest with = manifestOf(R"(, "omero": {"channels": [{"window": {"start": 3, "end": 9}}]})");
  EXPECT_EQ(with.format, kFormatVersion);
  EXPECT_EQ(with.look, (DeclaredLook{DeclaredLook::Ramp{3, 9, {}}, {}}));
}

// Known: no chunk is decoded twice if all fit. The plan is an upper bound for one lane, whatever the memory, and orders
// of bricks change no byte.
TEST_F(ZarrConversion, DecodingsAreAsPlanned) {
  const ForeignVolume volume = randomVolume({140, 120, 100}, VoxelType::u8, 52);
  fs::remove_all(folder());
  writeZarr(folder(), volume, ofChunks(16, 16, 16, ZarrVersion::kTwo, ZarrCodec::kRaw));
  const ThreadLimit one(1);
  std::map<std::string, std::vector<std::byte>> expected;
  const std::uint64_t ample = planConversion(*openSource(folder()), smallBricks()).once_bytes;
  for (const std::uint64_t less : {0u, 400u << 10, 600u << 10, 900u << 10}) {
    ConvertOptions options = smallBricks();
    options.memory_bytes = ample - less;
    const auto source = openSource(folder());
    const ConversionPlan plan = planConversion(*source, options);
    const fs::path out = freshDirectory("store") / "volume.kiln";
    Progress silent;
    const ConvertReport report = convert(*source, out, options, silent);
    EXPECT_EQ(plan.order->isLayers(), less == 0) << less;
    EXPECT_GE(report.decodings, 1) << less;
    EXPECT_LE(report.decodings, plan.decodings + 1e-9) << less;
    if (less == 0) EXPECT_EQ(report.decodings, 1);
    if (expected.empty()) expected = storeFiles(out);
    EXPECT_TRUE(storeFiles(out) == expected) << less;
  }
}

// Known: blocks that do not fit are decoded again, so that a plan with few decodings has room for its blocks.
TEST_F(ZarrConversion, PlannedDecodings_haveRoomForTheirBlocks) {
  fs::remove_all(folder());
  writeZarr(folder(), randomVolume({140, 120, 100}, VoxelType::u8, 54),
            ofChunks(16, 16, 16, ZarrVersion::kTwo, ZarrCodec::kRaw));
  const ThreadLimit one(1);
  const auto source = openSource(folder());
  const std::uint64_t block_bytes = source->decodedBlocks()->bytes + BlockCache::kOwnBytes,
                      ample = planConversion(*source, smallBricks()).once_bytes;
  for (std::uint64_t less = 0; less < 900u << 10; less += 1000) {
    ConvertOptions options = smallBricks();
    options.memory_bytes = ample - less;
    const ConversionPlan plan = planConversion(*source, options);
    const DecodingCost cost = decodingCost(*plan.order, {16, 16, 16});
    EXPECT_TRUE(plan.kept_bytes >= cost.blocks_kept * block_bytes || plan.decodings > cost.decodings) << less;
  }
}

constexpr const char* kLabelImage = R"({"image-label": {"version": "0.4"}, "multiscales": [{"version": "0.4",
    "axes": [{"name": "z", "type": "space"}, {"name": "y", "type": "space"}, {"name": "x", "type": "space"}],
    "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [4, 3, 2]}]}]}]})";

// An image of OME-Zarr that states "image-label".
fs::path writeLabelImage(const fs::path& folder, VoxelType type) {
  writeBelow(folder / ".zgroup", R"({"zarr_format": 2})");
  writeBelow(folder / ".zattrs", kLabelImage);
  writeZarr(folder / "0", randomVolume(kFewVoxels, type, 53));
  return folder;
}

TEST_F(ZarrConversion, FinishedStoreOfLabelsByTheHeader_IsResumed) {
  const fs::path image = writeLabelImage(folder(), VoxelType::u16), out = freshDirectory("labels") / "volume.kiln";
  ConvertOptions options = smallBricks();
  Progress silent;
  convert(*openSource(image), out, options, silent);
  const auto expected = storeFiles(out);
  options.overwrite = false;
  options.resume = true;
  EXPECT_GT(convert(*openSource(image), out, options, silent).bricks, 0u);
  EXPECT_TRUE(storeFiles(out) == expected);
}

TEST_F(ZarrConversion, LabelsByTheHeader_areNotRoundedAndAreWhole) {
  const fs::path out = freshDirectory("labels") / "v.kiln";
  ConvertOptions rounded = smallBricks();
  rounded.half = true;
  Progress silent;
  const auto labels = openSource(writeLabelImage(folder() / "u16", VoxelType::u16));
  expectError([&] { convert(*labels, out, rounded, silent); }, ErrorCode::kUsage, "--half: ");
  EXPECT_FALSE(fs::exists(out));
  const auto fractions = openSource(writeLabelImage(folder() / "f32", VoxelType::f32));
  EXPECT_EQ(fractions->info().volume_class, VolumeClass::kUnknown);
  ASSERT_EQ(fractions->info().notes.size(), 1u);
  EXPECT_EQ(fractions->info().notes.front(), "states labels, but its values are fractions; read as amounts");
}

}  // namespace
}  // namespace kiln::test
