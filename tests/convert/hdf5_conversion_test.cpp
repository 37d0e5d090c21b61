// A damaged HDF5 file becomes a store, or one line of an error, within the memory of the conversion. Known because a
// volume of 240 bytes needs little memory, whatever lengths a damaged header states.
#include <gtest/gtest.h>

#include <random>

#include "base/memory/memory.h"
#include "ingest/open_source.h"
#include "support/files/hdf5_files.h"
#include "support/system/sanitized.h"
#include "support/volumes/conversions.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr Extent3 kFewDims = {6, 5, 4};

void convertFlipped(int cases, std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewDims, VoxelType::u16, seed);
  const fs::path file = files.directory() / "a.h5";
  Hdf5File(file).add("/v", volume, {.chunk = {2, 3, 4}, .shuffle = true, .fletcher32 = true, .deflate = 1});
  const std::string whole = bytesOf(file);
  ConvertOptions options = smallBricks();
  options.memory_bytes = 64 << 20;
  SourceOptions source_options;
  source_options.memory_bytes = options.memory_bytes;
  std::mt19937_64 random(seed);
  int stores = 0, refused = 0;
  const auto convertIt = [&] {
    const fs::path out = freshDirectory("flipped") / "volume.kiln";
    Progress silent;
    bool done = false;
    try {
      const std::unique_ptr<VolumeSource> source = openSource(file, source_options);
      // A volume of missing chunks has any size that its header states.
      if (source->info().geometry.dims.count() > 1'000'000) return;
      convert(*source, out, options, silent);
      done = true;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
    ++(done ? stores : refused);
    EXPECT_EQ(fs::exists(out / "manifest.json"), done);
  };
  convertIt();
  ASSERT_EQ(stores, 1);
  const std::uint64_t before = peakResidentBytes();
  for (int i = 0; i < cases && !::testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE("case " + std::to_string(i));
    std::string damaged = whole;
    for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips)
      damaged[random() % damaged.size()] ^= static_cast<char>(1u << (random() % 8));
    files.write("a.h5", damaged);
    convertIt();
    if (!kSanitized) EXPECT_LT(peakResidentBytes() - before, options.memory_bytes);
  }
  EXPECT_GT(refused, cases / 10);
  EXPECT_GT(stores, cases / 10);
}

TEST(Hdf5Conversion, FlippedFileIsAStoreOrAnErrorInItsMemory) { convertFlipped(casesOf(100, 20), 1); }

TEST(Hdf5Conversion, NightlyFlippedFilesAreStoresOrErrorsInTheirMemory) { convertFlipped(10000, 2); }

}  // namespace
}  // namespace kiln::test
