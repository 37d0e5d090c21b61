#include "support/volumes/test_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "base/file/file.h"
#include "base/hash.h"
#include "base/progress.h"
#include "convert/convert.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"
#include "store/verify.h"

namespace kiln::test {
namespace fs = std::filesystem;

fs::path freshDirectory(const std::string& name) {
  std::string test = "no_test";
  if (const auto* info = ::testing::UnitTest::GetInstance()->current_test_info())
    test = std::string(info->test_suite_name()) + "." + info->name();
  std::replace(test.begin(), test.end(), '/', '_');
  const fs::path directory = fs::path(KILN_TEST_OUTPUT_DIR) / test / name;
  fs::remove_all(directory);
  fs::create_directories(directory);
  return directory;
}

fs::path makeStore(const DenseVolume& volume, const std::string& name, std::int64_t brick_size, bool labels) {
  const fs::path store = freshDirectory(name) / "volume.kiln";
  DenseSource source(volume);
  ConvertOptions options;
  options.brick_size = brick_size;
  options.labels = labels;
  options.command = "test " + name;
  options.time = "2000-01-01T00:00:00Z";  // constant, so that equal stores are equal bytes
  Progress silent;
  convert(source, store, options, silent);
  return store;
}

void writeText(const fs::path& path, std::string_view text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  ASSERT_TRUE(out.flush().good()) << path;
}

std::map<std::string, std::vector<std::byte>> filesOf(const fs::path& directory) {
  std::map<std::string, std::vector<std::byte>> out;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) out[fs::relative(entry.path(), directory).string()] = readFile(entry.path());
  }
  return out;
}

std::uint64_t wholeFiles(const fs::path& store) {
  Progress silent;
  return verify(
             StoreReader(store), 1ull << 30, [](const Error& damage) { throw damage; }, silent)
      .files;
}

namespace {

// Clears the counts of sub-bricks, which format 2 does not have.
void zeroSubBrickCounts(const BrickIndex& index, std::vector<std::byte>& data) {
  std::size_t at = 12;
  for (int level = 0; level < index.levels(); ++level) {
    at += 24;
    for (std::int64_t i = 0; i < index.lattice(level).count(); ++i) {
      const BrickEntry& entry = index.at({level, brickAt(index.lattice(level), i)});
      std::fill_n(data.begin() + static_cast<std::ptrdiff_t>(at) + 4, 4, std::byte{0});
      at += 64 + (entry.sub_ranges ? entry.sub_ranges->bytes().size() : 0);
    }
  }
}

}  // namespace

void makeFormat(int format, const fs::path& store) {
  constexpr std::size_t kDigitOfMagic = 7;
  const StoreReader reader(store);
  const Manifest& now_manifest = reader.manifest();
  if (format == 3) {
    Manifest manifest = now_manifest;
    manifest.format = format;
    return writeText(store / "manifest.json", manifestText(manifest));
  }
  BrickIndex index = reader.index();
  for (int level = 0; level < index.levels(); ++level) {
    for (std::int64_t i = 0; i < index.lattice(level).count(); ++i) {
      const BrickKey key{level, brickAt(index.lattice(level), i)};
      BrickEntry& entry = index.at(key);
      if (!std::exchange(entry.sub_ranges, nullptr) || format == 1) continue;
      const BrickBlock block = reader.read(key);
      const std::vector<ValueRange> ranges = subBrickRanges(block.voxels, block.type, block.extent, block.core,
                                                            now_manifest.brick_size, kEarlierSubBricks);
      entry.sub_ranges = std::make_shared<const SubRanges>(kEarlierSubBricks, ranges, entry.support);
    }
  }
  std::vector<std::byte> data = index.encode();
  data[kDigitOfMagic] = static_cast<std::byte>('0' + format);
  zeroSubBrickCounts(index, data);
  Manifest manifest = now_manifest;
  manifest.format = format;
  manifest.index_bytes = data.size();
  manifest.index_checksum = hashOf(data);
  writeText(store / "index.bin", {reinterpret_cast<const char*>(data.data()), data.size()});
  writeText(store / "manifest.json", manifestText(manifest));
}

std::string restamped(std::string manifest) {
  const std::string key = "\"checksum\": \"";
  const std::size_t digits = manifest.rfind(key) + key.size();
  manifest.replace(digits, 32, 32, '0');
  return manifest.replace(digits, 32, toHex(hashOf(manifest)));
}

}  // namespace kiln::test
