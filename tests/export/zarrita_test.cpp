// Zarr files of the tests, and exports, read by zarrita, a library in JavaScript that shares no code with Kiln. Known
// because the test made the voxels, or because the export of each level as raw voxels has them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/progress.h"
#include "base/shell_text.h"
#include "export/export_store.h"
#include "support/files/foreign_files.h"
#include "support/files/zarr_files.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Compares each folder F of the command line with the voxels of F.raw. An array may lie in memory in another order.
constexpr const char* kScript = R"(
import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
const load = (name) => import(pathToFileURL(`${process.argv[2]}/node_modules/${name}`));
const zarr = await load('zarrita/dist/src/index.js');
const { default: FileSystemStore } = await load('@zarrita/storage/dist/src/fs.js');
// zarrita takes a shard's index from the end, whatever the header says. Here it gets the bytes at the start instead.
// The rest is zarrita's: the length and the checksum of the index, places of chunks, codecs.
class IndexAtStart extends FileSystemStore {
  getRange(key, range, options) {
    const { suffixLength } = range;
    return super.getRange(key, suffixLength === undefined ? range : { offset: 0, length: suffixLength }, options);
  }
}
const storeOf = (path) => {
  const { codecs } = JSON.parse(readFileSync(path + '/zarr.json', 'utf8'));
  const shards = codecs.find(({ name }) => name === 'sharding_indexed');
  return new (shards?.configuration.index_location === 'start' ? IndexAtStart : FileSystemStore)(path);
};
let wrong = 0;
for (const path of process.argv.slice(3)) {
  try {
    const { shape, stride, data } = await zarr.get(await zarr.open.v3(storeOf(path), { kind: 'array' }));
    const found = new data.constructor(data.length);
    let at = 0;
    for (let z = 0; z < shape[0]; ++z)
      for (let y = 0; y < shape[1]; ++y)
        for (let x = 0; x < shape[2]; ++x) found[at++] = data[z * stride[0] + y * stride[1] + x * stride[2]];
    if (Buffer.from(found.buffer).equals(readFileSync(path + '.raw'))) continue;
    console.error(path + ': zarrita reads other voxels');
  } catch (error) {
    console.error(path + ': ' + error.message);
  }
  ++wrong;
}
process.exit(wrong > 0 ? 1 : 0);
)";

class Zarrita : public ::testing::Test {
 protected:
  // The fixture is read by Kiln, too.
  void add(const ForeignVolume& volume, const ZarrLayout& layout) {
    const fs::path folder = writeZarr(files_.directory() / fmt::format("{}.zarr", folders_.size()), volume, layout);
    writeText(folder.string() + ".raw", volume.stored(false));
    SCOPED_TRACE(folder);
    expectReadsBack(volume, folder, 311);
    folders_.push_back(folder);
  }

  void expectRead() {
    const fs::path script = files_.write("read.mjs", kScript);
    std::string command =
        shellText(KILN_TEST_NODE) + " " + shellText(script.string()) + " " + shellText(KILN_TEST_ZARRITA);
    for (const fs::path& folder : folders_) command += " " + shellText(folder.string());
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
  }

  ForeignFiles files_;
  std::vector<fs::path> folders_;
};

constexpr ZarrCodec kCommonCodecs[] = {ZarrCodec::kRaw, ZarrCodec::kGzip, ZarrCodec::kZstd, ZarrCodec::kBlosc};

TEST_F(Zarrita, readsEveryFixtureOfVersionThreeAsKilnDoes) {
  for (const VoxelType type : kAllTypes)
    for (const bool big_endian : {false, true})
      add(randomVolume(kFewVoxels, type, 312), {.version = ZarrVersion::kThree, .big_endian = big_endian});
  const ForeignVolume volume = randomVolume({11, 9, 8}, VoxelType::u16, 313);
  for (const ZarrCodec codec : kCommonCodecs)
    for (const bool checksum : {false, true})
      add(volume, {.version = ZarrVersion::kThree, .codec = codec, .stored_axes = {2, 0, 1}, .checksum = checksum});
  expectRead();
}

TEST_F(Zarrita, readsEveryFixtureOfShardsAsKilnDoes) {
  const ForeignVolume volume = randomVolume({11, 9, 8}, VoxelType::u16, 314);
  for (const ZarrCodec codec : kCommonCodecs) {
    for (const bool checksum : {false, true}) {
      ZarrLayout layout{.version = ZarrVersion::kThree, .codec = codec, .chunks_in_shard = 2, .checksum = checksum};
      if (checksum) layout.stored_axes = {2, 0, 1};
      for (const bool at_start : {false, true}) {
        layout.index_at_start = at_start;
        add(volume, layout);
      }
    }
  }
  expectRead();
}

TEST_F(Zarrita, readsEveryLevelOfAnExport) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::i16, VoxelType::f32}) {
    const fs::path path =
        makeStore(noise({{150, 70, 90}, type}, 315, usualRange(type)), "zarrita_" + std::string(nameOf(type)), 32);
    const StoreReader store(path);
    Progress silent;
    ExportRequest request;
    request.out = files_.directory() / fmt::format("{}.ome.zarr", nameOf(type));
    exportStore(store, request, silent);
    const int levels = static_cast<int>(store.manifest().levels.size());
    EXPECT_GT(levels, 2);
    for (int level = 0; level < levels; ++level) {
      ExportRequest raw;
      raw.level = level;
      folders_.push_back(request.out / std::to_string(level));
      raw.out = folders_.back().string() + ".raw";
      exportStore(store, raw, silent);
    }
  }
  expectRead();
}

}  // namespace
}  // namespace kiln::test
