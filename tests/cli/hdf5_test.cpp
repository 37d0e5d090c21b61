// Arrays of HDF5 and Zarr on the command line. Known because a raw file has the same voxels.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/files/hdf5_files.h"
#include "support/files/zarr_files.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
using Json = nlohmann::json;

class ArraysCli : public ToolTest {
 protected:
  ArraysCli() : ToolTest("arrays_") {}
  void SetUp() override {
    const ForeignVolume volume = randomVolume({13, 11, 9}, VoxelType::i16, 1);
    writeText(in("v.raw"), volume.stored(false));
    {
      Hdf5File file(in("a.h5"));
      file.add("/group/v", volume, {.chunk = {4, 5, 6}, .shuffle = true, .deflate = 1});
      file.add("/w", randomVolume(kFewVoxels, VoxelType::u8, 2));
    }
    writeZarr(in("a.zarr"), volume);
  }

  Json listed(const std::string& name) const {
    return Json::parse(done({"convert", in(name), "--list", "--json"}).out)["volumes"];
  }
  void expectValuesOfTheRawFile(const std::string& array) const {
    SCOPED_TRACE(array);
    const Json found = Json::parse(done({"info", array, "--json"}).out),
               raw = Json::parse(done({"info", in("v.raw"), "--dims", "13,11,9", "--type", "i16", "--json"}).out);
    for (const char* key : {"histogram", "range", "affine", "type"}) EXPECT_EQ(found[key], raw[key]) << key;
    done({"convert", array, in("c.kiln"), "--overwrite"});
    for (const char* function : {"auto", "ct-bone"})
      EXPECT_EQ(done({"tf", array, "--tf", function, "--json"}).out,
                done({"tf", in("c.kiln"), "--tf", function, "--json"}).out);
  }
};

TEST_F(ArraysCli, DataSetOfAFile_isListedWithItsPathAndReadByIt) {
  const Json volumes = listed("a.h5");
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_EQ(volumes[0]["name"], "/group/v");
  EXPECT_EQ(volumes[0]["dimensions"], Json({13, 11, 9}));
  EXPECT_EQ(volumes[0]["type"], "i16");
  EXPECT_EQ(volumes[0]["option"], in("a.h5") + ":/group/v");
  EXPECT_EQ(volumes[1]["name"], "/w");
  EXPECT_EQ(volumes[1]["type"], "u8");
  expectValuesOfTheRawFile(volumes[0]["option"]);
  refused({"info", in("a.h5")}, 2, "holds 2 data sets: /group/v (9, 11, 13) int16; /w (3, 4, 5) uint8; name one");
  refused({"tf", in("a.h5") + ":/none"}, 1, "/none: there is no data set of this name");
}

TEST_F(ArraysCli, FolderOfZarr_isOneVolume) {
  const Json volumes = listed("a.zarr");
  ASSERT_EQ(volumes.size(), 1u);
  EXPECT_EQ(volumes[0]["dimensions"], Json({13, 11, 9}));
  EXPECT_EQ(volumes[0]["type"], "i16");
  EXPECT_EQ(volumes[0]["option"], "");
  expectValuesOfTheRawFile(in("a.zarr"));
}

}  // namespace
}  // namespace kiln::test
