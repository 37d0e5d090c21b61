// Volume files before any conversion: their values, their lists, and how they lie in the world. Known because the store
// of a small file counts the same voxels, and because files are written here.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "support/files/dicom_files.h"
#include "support/files/foreign_files.h"
#include "support/files/tiff_files.h"
#include "support/files/vdb_files.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

class Inputs : public ToolTest {
 protected:
  Inputs() : ToolTest("inputs_") {}
  void SetUp() override {
    writeText(in("v.raw"), randomVolume({12, 10, 8}, VoxelType::i16, 3).stored(false));
    writeText(in("v.nhdr"),
              "NRRD0004\ntype: int16\ndimension: 3\nsizes: 12 10 8\nendian: little\nencoding: raw\n"
              "spacings: 1 1 2\ndata file: v.raw\n");
  }
  static void expectSays(const ToolResult& result, const std::string& text) {
    EXPECT_NE(result.out.find(text), std::string::npos) << "'" << text << "' is not in: " << result.out;
  }
  Json listed(const std::string& name) const {
    return Json::parse(done({"convert", in(name), "--list", "--json"}).out)["volumes"];
  }
};

TEST_F(Inputs, TransferFunctionsOfAFile_AreThoseOfItsStore) {
  done({"convert", in("v.nhdr"), in("v.kiln")});
  for (const char* preset : {"auto", "ct-bone", "viridis", "mr-head"})
    EXPECT_EQ(done({"tf", in("v.nhdr"), "--tf", preset, "--json"}).out,
              done({"tf", in("v.kiln"), "--tf", preset, "--json"}).out)
        << preset;
  const ToolResult shown = done({"tf", in("v.nhdr"), "-o", in("tf.png")});
  for (const char* text : {"volume       values -32768 to 32767\n", "histogram    of all 960 voxels; ",
                           "the middle 99 % of the values", "lung\n", "points; extinction"})
    expectSays(shown, text);
  EXPECT_TRUE(fs::exists(in("tf.png")));
  EXPECT_FALSE(fs::exists(in("v.nhdr.kiln"))) << "converted";
  refused({"tf", in("v.nhdr"), "-o", in("v.raw")}, 2, "v.raw");
  refused({"tf", "ct-bone", "--channel", "1"}, 2, "'ct-bone' is no volume file");
  // The store of a picture has all values.
  done({"slice", in("v.nhdr"), "-o", in("s.png"), "--store", in("stores")});
  expectSays(done({"tf", in("v.nhdr"), "--store", in("stores")}),
             "histogram    of all voxels, by the store " + in("stores"));
}

TEST_F(Inputs, InfoOfAFile_HasItsHistogram) {
  done({"convert", in("v.nhdr"), in("v.kiln")});
  const Json file = Json::parse(done({"info", in("v.nhdr"), "--json"}).out),
             store = Json::parse(done({"info", in("v.kiln"), "--json"}).out);
  for (const char* key : {"histogram", "range", "nanCount", "affine", "type"}) EXPECT_EQ(file[key], store[key]) << key;
  EXPECT_EQ(file["sample"]["voxels"], 960);
  expectSays(done({"info", in("v.nhdr")}), "values       -32768 to 32767, background 0, class unknown\n");
  // The header of a damaged file is printed before the error.
  const std::string packed = gzipped(bytesOf(in("v.raw")));
  writeText(in("cut.nrrd"), "NRRD0004\ntype: int16\ndimension: 3\nsizes: 12 10 8\nendian: little\nencoding: gzip\n\n" +
                                packed.substr(0, packed.size() / 2));
  const ToolResult cut = runTool({"info", in("cut.nrrd")});
  EXPECT_EQ(cut.exit_code, 1);
  expectSays(cut, "dimensions   12 x 10 x 8 voxels");
  EXPECT_NE(cut.err.find("cut.nrrd: byte "), std::string::npos) << cut.err;
}

// Known: values from 101325 on, in steps of 0.01. Six digits would make all rows and windows equal.
TEST_F(Inputs, TfTellsValuesWithAnOffsetApart) {
  std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: text\n\n";
  for (int i = 0; i < 64; ++i) text += fmt::format("{:.2f} ", 101325 + 0.01 * i);
  writeText(in("offset.nrrd"), text + "\n");
  const ToolResult tf = done({"tf", in("offset.nrrd")});
  expectSays(tf, "101325.04 to 101325.08");
  EXPECT_EQ(tf.out.find("window       101325,"), std::string::npos) << tf.out;
}

// Known: all other values lie from 0 to 1, which are no Hounsfield units.
TEST_F(Inputs, TfProposesNoWindowsForSingleInfinities) {
  std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: text\n\ninf -inf";
  for (int i = 2; i < 64; ++i) text += fmt::format(" {:.2f}", i / 64.0);
  writeText(in("infinite.nrrd"), text + "\n");
  EXPECT_EQ(done({"tf", in("infinite.nrrd")}).out.find("Hounsfield"), std::string::npos);
}

TEST_F(Inputs, AListNamesEachVolume_WithTheOptionThatChoosesIt) {
  VdbSpec density, speed, tag;
  speed.name = "v", speed.kind = VdbKind::kVec3;
  tag.name = "tag", tag.kind = VdbKind::kInt32;
  fs::create_directory(in("all"));
  writeVdb(in("all/smoke.vdb"), {density, speed, tag});
  const Json grids = listed("all/smoke.vdb");
  ASSERT_EQ(grids.size(), 3u);
  EXPECT_EQ(grids[0]["name"], "density");
  EXPECT_EQ(grids[0]["option"], "--grid density");
  EXPECT_EQ(grids[0]["type"], "f32");
  EXPECT_EQ(grids[0]["dimensions"], Json({kVdbDims.x, kVdbDims.y, kVdbDims.z}));
  EXPECT_EQ(grids[1]["refusal"], "holds vectors, not one value a voxel");
  EXPECT_EQ(grids[2]["type"], "i32");
  // Two series, a stack of three slices and another of one, and a file.
  DicomSpec slice;
  slice.pixel_bytes = std::string(2 * 5 * 4, '\1');
  for (const char* series : {"1.2.3", "1.2.4"}) {
    slice.series = series;
    writeText(in("all/" + slice.series + ".dcm"), dicomFile(slice));
  }
  const ForeignVolume volume = randomVolume({16, 12, 1}, VoxelType::u16, 1);
  for (const char* name : {"a1.tif", "a2.tif", "a3.tif", "other.tif"})
    writeTiff(in(std::string("all/") + name), volume, 0, 1);
  fs::copy(in("v.raw"), in("all/v.raw"));
  fs::copy(in("v.nhdr"), in("all/v.nhdr"));
  const ToolResult all = done({"convert", in("all"), "--list"});
  expectSays(all, in("all") + ": 8 volumes\n");
  expectSays(all, "  1.2.3             CT 'a series'  ");
  expectSays(all, "--series 1.2.4\n");
  expectSays(all, "  a1.tif to a3.tif  TIFF");
  expectSays(all, "16 x 12 x 3 of u16 (1.12 KiB)");
  expectSays(all, "int32 in 'smoke.vdb'");
  expectSays(all, in("all/smoke.vdb") + " --grid tag\n");
  expectSays(all, "12 x 10 x 8 of i16 (1.88 KiB)");
}

TEST_F(Inputs, PagesOfSeveralChannels_AreListedAsOneStackOfEach) {
  TiffLayout layout;
  layout.description = "ImageJ=1.54f\nimages=4\nchannels=2\nslices=2\nhyperstack=true\n";
  writeTiff(in("h.tif"), randomVolume(kStackDims, VoxelType::u8, 1), 0, 4, layout);
  const Json pages = listed("h.tif");
  ASSERT_EQ(pages.size(), 1u);
  EXPECT_EQ(pages[0]["dimensions"], Json({21, 19, 2}));
  EXPECT_EQ(pages[0]["kind"], "TIFF, 2 channels");
  EXPECT_EQ(pages[0]["option"], "--channel N");
  EXPECT_EQ(listed("v.nhdr")[0]["kind"], "NRRD");
  refused({"convert", in("v.nhdr"), in("o.kiln"), "--json"}, 2, "--json requires --list");
}

TEST_F(Inputs, WordsOnOrientation_ChangeTheAffineAndRenewTheStore) {
  const auto raw = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"info", in("v.raw"), "--json", "--dims", "12,10,8", "--type", "i16"});
    return Json::parse(done(words).out);
  };
  EXPECT_EQ(raw({"--orient", "LPS", "--spacing", "1,1,2"})["affine"],
            Json({-1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(raw({"--orient", "LPS"})["frame"], "RAS");
  EXPECT_EQ(raw({"--flip", "x,z"})["affine"],
            Json({-1.0, 0.0, 0.0, 11.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 7.0, 0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(raw({"--unit", "micron"})["unit"], "um");
  EXPECT_EQ(raw({"--up", "y"})["affine"], raw({"--up-axis", "y"})["affine"]);
  for (const auto& [option, wrong] :
       {std::pair{"--flip", "x,x"}, {"--flip", "w"}, {"--orient", "LLS"}, {"--up-axis", "x"}, {"--unit", "furlong"}})
    refused({"info", in("v.nhdr"), option, wrong}, 2, std::string(option) + ": expected");
  const auto conversions = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", in("v.nhdr"), "-o", in("p.png"), "--size", "16x16"});
    return done(words).err.find("converting") != std::string::npos;
  };
  EXPECT_TRUE(conversions({}));
  EXPECT_FALSE(conversions({}));
  EXPECT_TRUE(conversions({"--orient", "RAS"})) << "another frame, with an equal affine";
  EXPECT_TRUE(conversions({"--unit", "um"})) << "another unit, with an equal affine";
  EXPECT_TRUE(conversions({"--up-axis", "y"}));
  EXPECT_TRUE(conversions({"--up-axis", "y", "--flip", "y", "--up", "1,0,0"}));
  EXPECT_FALSE(conversions({"--up-axis", "y", "--flip", "y"}));
  refused({"render", in("v.nhdr.kiln"), "-o", in("p.png"), "--flip", "x"}, 2, "and this is a store");
}

}  // namespace
}  // namespace kiln::test
