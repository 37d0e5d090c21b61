// A gzip NRRD whose slices exceed the memory budget converts to the same files as with a large budget, and as the
// uncompressed voxels.
#include <gtest/gtest.h>

#include <map>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/volumes/conversions.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Slices larger than a strip; most bricks are constant and cost no time.
constexpr Extent3 kWideDims = {70000, 4, 60};
constexpr std::int64_t kBrickSize = 32, kStructured = 2500;

std::string voxels() {
  std::string out(static_cast<std::size_t>(kWideDims.count()), '\0');
  for (std::int64_t row = 0; row < kWideDims.y * kWideDims.z; ++row) {
    for (std::int64_t x = 0; x < kStructured; ++x) {
      out[static_cast<std::size_t>(row * kWideDims.x + x)] =
          static_cast<char>((3 * x + 5 * row + (x * row >> 6)) & 0xff);
    }
  }
  return out;
}

// Returns all files of the store by name, except the manifest, which names the source.
std::map<std::string, std::vector<std::byte>> converted(const fs::path& input, std::uint64_t memory_bytes) {
  const fs::path out = freshDirectory("store") / "volume.kiln";
  const std::unique_ptr<VolumeSource> source = openSource(input);
  ConvertOptions options;
  options.brick_size = kBrickSize;
  options.memory_bytes = memory_bytes;
  Progress silent;
  const ConvertReport report = convert(*source, out, options, silent);
  EXPECT_LE(report.buffer_bytes, memory_bytes);
  return storeFiles(out);
}

TEST(CompressedConversion, NeedsNoSliceInMemory) {
  const std::string header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 70000 4 60\nspacings: 1 1 2\nencoding: ",
                    bytes = voxels();
  const ForeignFiles files;
  const fs::path packed = files.write("packed.nrrd", header + "gzip\n\n" + gzipped(bytes));
  const fs::path plain = files.write("plain.nrrd", header + "raw\n\n" + bytes);
  constexpr std::uint64_t kLittle = 5 << 20, kAmple = 256 << 20;
  static_assert(2 * kLittle < (kBrickSize + 12) * kWideDims.x * kWideDims.y,
                "the slices of one layer of bricks do not fit");
  const auto expected = converted(plain, kAmple);
  EXPECT_GT(expected.size(), 100u);
  EXPECT_TRUE(converted(packed, kAmple) == expected);
  EXPECT_TRUE(converted(packed, kLittle) == expected);
}

}  // namespace
}  // namespace kiln::test
