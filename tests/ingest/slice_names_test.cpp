// Folders of slices by their names alone: a single stack without a gap, or an error that names the fault.
#include "ingest/slice_names.h"

#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/tiff_files.h"

namespace kiln::test {
namespace {

SliceFiles slicesOf(std::vector<std::string> names) {
  std::sort(names.begin(), names.end(), naturallyBefore);
  return {"scan", SliceFormat::kTiff, {names.begin(), names.end()}, {}, {}};
}

// Returns the notes where irregular names are allowed, and expects that all files stay.
std::vector<std::string> notesOn(SliceFiles slices) {
  const std::vector<std::filesystem::path> files = slices.files;
  SourceOptions irregular;
  irregular.allow_irregular = true;
  requireOneStack(slices, irregular);
  EXPECT_EQ(slices.files, files);
  return slices.notes;
}

void expectStack(const std::vector<std::string>& names) {
  SliceFiles slices = slicesOf(names);
  requireOneStack(slices, {});
  EXPECT_EQ(slices.files, slicesOf(names).files);
  EXPECT_TRUE(slices.notes.empty());
  EXPECT_TRUE(notesOn(slices).empty());
}

void expectNoStack(const std::vector<std::string>& names, ErrorCode code, const std::string& part) {
  SliceFiles slices = slicesOf(names);
  expectError([&] { requireOneStack(slices, {}); }, code, part);
  EXPECT_EQ(notesOn(slices).size(), 1u);
}

TEST(SliceNames, OneNumberWithConstantStep_IsAStack) {
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"a.tif"},
        {"s1.tif", "s2.tif", "s10.tif", "s9.tif", "s8.tif", "s7.tif", "s6.tif", "s5.tif", "s4.tif", "s3.tif"},
        {"s000.tif", "s005.tif", "s010.tif"},
        {"2021-03-04 head_0.tif", "2021-03-04 head_1.tif"},
        {"1.tif", "2.tif"},
        {"s98", "s99", "s100"}})
    expectStack(names);
}

TEST(SliceNames, MissingSlice_IsNamed) {
  const auto expectMissing = [](const std::vector<std::string>& names, const std::string& part) {
    expectNoStack(names, ErrorCode::kFormat, part);
  };
  expectMissing({"s08.tif", "s09.tif", "s11.tif", "s12.tif"},
                "scan: 's09.tif' is followed by 's11.tif': 's10.tif' is missing; --allow-irregular takes all files in "
                "the order of their names");
  expectMissing({"s1", "s2", "s3", "s7", "s8", "s11"}, "'s4' to 's6' are missing (2 such places)");
  expectMissing({"s0", "s2", "s4", "s5", "s7"}, "'s4' is followed by 's5': a step of 1 where others are 2");
}

TEST(SliceNames, TwoChannels_AreListed) {
  std::vector<std::string> numbered, named;
  for (int z = 0; z < 12; ++z) {
    for (const char* channel : {"00", "01"})
      numbered.push_back("img_z" + std::to_string(100 + z) + "_ch" + channel + ".tif");
    for (const char* channel : {"dapi", "gfp"}) named.push_back("z" + std::to_string(z) + "_" + channel + ".tif");
  }
  expectNoStack(numbered, ErrorCode::kUsage,
                "2 groups, not one numbered stack: 'img_z*_ch00.tif' (12 files), 'img_z*_ch01.tif' (12 files)");
  expectNoStack(named, ErrorCode::kFormat, "'z*_dapi.tif' (12 files), 'z*_gfp.tif' (12 files)");
  expectNoStack({"s1.tif", "s2.tif", "mean.tif"}, ErrorCode::kFormat, "'mean.tif', 's*.tif' (2 files)");
}

// Known: the channel is the second number of the names, and each file is named after its place.
TEST(SliceNames, SecondNumber_isChosenByChannelOrTime) {
  SliceFiles all{"scan", SliceFormat::kTiff, {}, {}, {}};
  for (int z = 8; z < 12; ++z) {
    for (int c = 1; c < 4; ++c) all.files.push_back("z" + std::to_string(z) + "_c00" + std::to_string(c) + ".tif");
  }
  const auto chosen = [&](const SourceOptions& options) {
    SliceFiles out = all;
    requireOneStack(out, options);
    EXPECT_EQ(out.files.size(), 4u);
    return out.files.front().string() + out.part;
  };
  SourceOptions options;
  options.channel = "2";
  EXPECT_EQ(chosen(options), "z8_c002.tif, channel 2");
  options.channel = "003";
  EXPECT_EQ(chosen(options), "z8_c003.tif, channel 003");
  options = {}, options.time = 1;
  EXPECT_EQ(chosen(options), "z8_c001.tif, time 1");
  const auto refused = [&](const SourceOptions& wrong, const std::string& part) {
    SliceFiles out = all;
    expectError([&] { requireOneStack(out, wrong); }, ErrorCode::kUsage, part);
  };
  refused({}, "'z*_c003.tif' (4 files); choose one by its number with --channel");
  options = {}, options.channel = "0";
  refused(options, "--channel: no name has the number '0'");
  options.channel = "2", options.time = 1;
  refused(options,
          "--time: the names have one number beside the slices' (found --channel, too); leave one of them out");
}

TEST(SliceNames, NumbersThatAreEqualOrTooLong_AreErrors) {
  expectNoStack({"s1.tif", "s01.tif", "s2.tif"}, ErrorCode::kFormat, "have the same number");
  expectNoStack({"s1.tif", "s01.tif"}, ErrorCode::kFormat, "have the same number");
  expectNoStack({"s99999999999999999999998.tif", "s99999999999999999999999.tif"}, ErrorCode::kFormat, "too long");
}

TEST(SliceNames, FolderWithAGap_IsReadWhereAllowed) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 20);
  for (const int z : {0, 1, 3}) writeTiff(files.directory() / ("s" + std::to_string(z) + ".tif"), volume, z, z + 1);
  expectRefused(files.directory(), ErrorCode::kFormat, "'s1.tif' is followed by 's3.tif': 's2.tif' is missing");
  SourceOptions options;
  options.allow_irregular = true;
  const auto source = openSource(files.directory(), options);
  EXPECT_EQ(source->info().geometry.dims.z, 3);
  EXPECT_NE(source->info().notes.front().find("'s2.tif' is missing; took all files"), std::string::npos);
}

}  // namespace
}  // namespace kiln::test
