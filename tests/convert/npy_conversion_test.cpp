// An array in C order, in Fortran order and as raw voxels becomes one store, within a budget of one lane. Known because
// the three files hold equal voxels. A damaged array becomes no store.
#include <gtest/gtest.h>

#include <random>

#include "ingest/open_source.h"
#include "support/files/npy_files.h"
#include "support/volumes/conversions.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Three, two and two bricks along the axes.
constexpr Extent3 kDims = {75, 40, 50};

TEST(NpyConversion, EitherOrderGivesTheStoreOfTheRawVoxels) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kDims, VoxelType::u16, 1);
  SourceOptions described;
  described.dims = volume.dims, described.type = volume.type;
  const auto expected = convertedInOneLane(*openSource(files.write("a.raw", volume.stored(false)), described));
  EXPECT_GT(expected.size(), 12u);
  for (const bool fortran_order : {false, true}) {
    for (const bool big_endian : {false, true}) {
      const fs::path array = files.write("a.npy", npyFile(volume, {1, big_endian, fortran_order}));
      EXPECT_TRUE(convertedInOneLane(*openSource(array)) == expected)
          << "Fortran " << fortran_order << ", big " << big_endian;
    }
  }
}

// Cuts at random bytes and flips of the header's bits: a store with a manifest, or an Error and no manifest. A cut is
// always an Error.
TEST(NpyConversion, DamagedArrayIsAStoreOrAnError) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({20, 12, 9}, VoxelType::i16, 2);
  std::mt19937_64 random(3);
  for (const bool fortran_order : {false, true}) {
    const std::string whole = npyFile(volume, {.fortran_order = fortran_order});
    const std::size_t header_bytes = whole.size() - volume.voxels.size();
    for (int i = 0; i < 60; ++i) {
      const bool cut = i % 2 == 0;
      std::string damaged = cut ? whole.substr(0, random() % whole.size()) : whole;
      if (!cut) damaged[random() % header_bytes] ^= static_cast<char>(1u << (random() % 8));
      const fs::path out = freshDirectory("damaged") / "volume.kiln";
      Progress silent;
      bool done = false;
      try {
        convert(*openSource(files.write("a.npy", damaged)), out, smallBricks(), silent);
        done = true;
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
      EXPECT_EQ(fs::exists(out / "manifest.json"), done) << "case " << i;
      EXPECT_FALSE(cut && done) << "case " << i;
    }
  }
}

}  // namespace
}  // namespace kiln::test
