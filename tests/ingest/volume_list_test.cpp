// Lists of volumes by headers alone. Known because the same files are opened as volumes.
#include "ingest/volume_list.h"

#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/dicom_files.h"
#include "support/files/nifti_files.h"
#include "support/files/picture_files.h"
#include "support/files/tiff_files.h"
#include "support/files/vti_files.h"
#include "support/files/zarr_files.h"

namespace kiln::test {
namespace {

TEST(VolumeList, OmeSetOfSeveralFiles_HasTheSlicesOfOneChannel) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({21, 19, 6}, VoxelType::u8, 51);
  TiffLayout layout;
  layout.description =
      "<OME x=\"y\"><Pixels DimensionOrder=\"XYZCT\" SizeC=\"2\" SizeZ=\"3\" SizeT=\"1\"></Pixels></OME>";
  writeTiff(files.directory() / "a1.tif", volume, 0, 3, layout);
  writeTiff(files.directory() / "a2.tif", volume, 3, 6, layout);
  SourceOptions options;
  options.channel = "1";
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 1u);
  EXPECT_EQ(volumes[0].name, "a1.tif to a2.tif");
  EXPECT_EQ(volumes[0].option, "--channel N");
  EXPECT_EQ(volumes[0].dims, openSource(files.directory(), options)->info().geometry.dims);
}

TEST(VolumeList, FolderOfPictures_IsListedAsItIsRead) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({21, 19, 4}, VoxelType::u16, 52);
  for (std::int64_t z = 0; z < 4; ++z) files.write("s" + std::to_string(8 + z) + ".png", pngSlice(volume, z));
  auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 1u);
  EXPECT_EQ(volumes[0].name, "s8.png to s11.png");
  EXPECT_EQ(volumes[0].kind, "PNG");
  EXPECT_EQ(volumes[0].dims, volume.dims);
  EXPECT_EQ(volumes[0].type, volume.type);
  EXPECT_EQ(volumes[0].refusal, "");
  files.write("colours.jpg", jpegFile(4, 4, 3, std::string(48, 'x')));
  volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_EQ(volumes[1].kind, "JPEG");
  EXPECT_NE(volumes[1].refusal.find("holds 3 colours a pixel"), std::string::npos) << volumes[1].refusal;
  // Pictures beside slices of another format are no slices.
  writeTiff(files.directory() / "t.tif", volume, 0, 1);
  volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 1u);
  EXPECT_EQ(volumes[0].kind, "TIFF");
}

// Known: three files of two series, of which one is cut inside its elements, and one inside its first group.
TEST(VolumeList, DamagedDicomFile_isListedWithItsReason) {
  const ForeignFiles files;
  DicomSpec spec;
  spec.pixel_bytes = std::string(40, '\0');
  const std::string whole = dicomFile(spec);
  files.write("a.dcm", whole);
  spec.series = "1.2.9";
  files.write("b.dcm", dicomFile(spec));
  files.write("c.dcm", whole.substr(0, whole.size() - 60));
  files.write("d.dcm", whole.substr(0, 150));
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 4u);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(volumes[i].name, i == 0 ? "c.dcm" : "d.dcm");
    EXPECT_NE(volumes[i].refusal.find(volumes[i].name), std::string::npos);
    EXPECT_TRUE(volumes[i].option.empty());
  }
  EXPECT_EQ(volumes[2].option, "--series 1.2.3.4");
  EXPECT_EQ(volumes[3].option, "--series 1.2.9");
  EXPECT_TRUE(volumes[2].refusal.empty() && volumes[3].refusal.empty());
  // A file alone is an error.
  expectError([&] { volumesIn(files.directory() / "c.dcm"); }, ErrorCode::kFormat, "c.dcm: byte");
}

// Known: a NIfTI of three times, and a VTK image of two arrays.
TEST(VolumeList, FileOfSeveralTimesOrChannels_HasTheOptionThatChooses) {
  const ForeignFiles files;
  NiftiHeader header;
  header.dim = {4, 5, 4, 1, 3, 1, 1, 1};
  writeBytes(files.directory() / "times.nii", niftiFile(header, Bytes(60)));
  const ForeignVolume volume = randomVolume({5, 4, 2}, VoxelType::u8, 3);
  VtiLayout layout;
  layout.format = "ascii";
  layout.scalars = "";
  std::string sevens;
  for (int i = 0; i < 40; ++i) sevens += " 7";
  layout.more_arrays = "<DataArray type=\"UInt8\" Name=\"w\" format=\"ascii\">" + sevens + "</DataArray>";
  files.write("channels.vti", vtiFile(volume, layout));
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_EQ(volumes[0].kind, "VTK image, 2 channels: 0 ('w'), 1 ('v')");
  EXPECT_EQ(volumes[0].option, (files.directory() / "channels.vti").string() + " --channel N");
  EXPECT_EQ(volumes[0].dims, (Extent3{5, 4, 2}));
  EXPECT_EQ(volumes[1].kind, "NIfTI-1, 3 times");
  EXPECT_EQ(volumes[1].option, (files.directory() / "times.nii").string() + " --time N");
  EXPECT_EQ(volumes[1].refusal, "");
}

// Known: the second stack is cut inside its directory of tags.
TEST(VolumeList, DamagedTiff_isListedWithItsReason) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 2}, VoxelType::u8, 3);
  writeTiff(files.directory() / "whole.tif", volume, 0, 2, {});
  files.write("z.tif", bytesOf(files.directory() / "whole.tif").substr(0, 20));
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_TRUE(volumes[0].refusal.empty());
  EXPECT_NE(volumes[1].refusal.find("z.tif"), std::string::npos);
}

// Known: the folder holds nothing but two arrays, and then a file, too.
TEST(VolumeList, ZarrInAFolder_isListedByItsPath) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 54);
  for (const char* const name : {"a10.zarr", "a9.zarr"}) writeZarr(files.directory() / name, volume);
  auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_EQ(volumes[0].name, "a9.zarr");
  EXPECT_EQ(volumes[0].option, (files.directory() / "a9.zarr").string());
  EXPECT_EQ(volumes[0].dims, kFewVoxels);
  EXPECT_EQ(volumes[0].type, VoxelType::u16);
  EXPECT_EQ(volumes[1].name, "a10.zarr");
  writeTiff(files.directory() / "t.tif", volume, 0, 1);
  volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 3u);
  EXPECT_EQ(volumes[0].kind, "TIFF");
}

TEST(VolumeList, TiffFileAmongOthers_isListedByItsPath) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 2}, VoxelType::u8, 55);
  writeTiff(files.directory() / "one.tif", volume, 0, 2);
  EXPECT_EQ(volumesIn(files.directory())[0].option, "");
  writeTiff(files.directory() / "two.tif", volume, 0, 2);
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_EQ(volumes[0].option, (files.directory() / "one.tif").string());
  EXPECT_EQ(openSource(volumes[1].option)->info().geometry.dims, volumes[1].dims);
}

// Known: a conversion refuses the folder for the same reason.
TEST(VolumeList, StackWithAGap_isListedWithTheReason) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 4}, VoxelType::u8, 56);
  for (const int z : {0, 1, 3}) writeTiff(files.directory() / ("s" + std::to_string(z) + ".tif"), volume, z, z + 1);
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 1u);
  EXPECT_NE(volumes[0].refusal.find("'s2.tif' is missing"), std::string::npos) << volumes[0].refusal;
  SourceOptions options;
  options.allow_irregular = true;
  EXPECT_EQ(volumesIn(files.directory(), options)[0].refusal, "");
}

TEST(VolumeList, StacksOfChannels_areListedWithTheOptionThatChoosesEach) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 6}, VoxelType::u8, 57);
  for (int z = 0; z < 3; ++z)
    for (int c = 0; c < 2; ++c)
      writeTiff(files.directory() / ("z" + std::to_string(z) + "_c0" + std::to_string(c) + ".tif"), volume, 3 * c + z,
                3 * c + z + 1);
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 2u);
  for (std::int64_t c = 0; c < 2; ++c) {
    const ListedVolume& stack = volumes[static_cast<std::size_t>(c)];
    EXPECT_EQ(stack.option, "--channel " + std::to_string(c));
    EXPECT_EQ(stack.refusal, "");
    SourceOptions options;
    options.channel = std::to_string(c);
    EXPECT_TRUE(readWhole(*openSource(files.directory(), options)) == volume.box({{0, 0, 3 * c}, {5, 4, 3 * c + 3}}));
  }
  // Stacks of other names are no volume.
  writeTiff(files.directory() / "other1.tif", volume, 0, 1);
  writeTiff(files.directory() / "other2.tif", volume, 0, 1);
  for (const ListedVolume& stack : volumesIn(files.directory()))
    EXPECT_NE(stack.refusal.find("form 2 groups, not one numbered stack"), std::string::npos) << stack.refusal;
}

TEST(VolumeList, DicomImagesAtOnePlace_areListedWithTheReason) {
  const ForeignFiles files;
  DicomSpec spec;
  spec.pixel_bytes = std::string(40, '\0');
  files.write("a.dcm", dicomFile(spec));
  files.write("b.dcm", dicomFile(spec));
  const auto volumes = volumesIn(files.directory());
  ASSERT_EQ(volumes.size(), 1u);
  EXPECT_NE(volumes[0].refusal.find("lie at the same place"), std::string::npos) << volumes[0].refusal;
}

TEST(VolumeList, HostileCountOfImages_HasNoOverflow) {
  const ForeignFiles files;
  TiffLayout layout;
  layout.description = "ImageJ=1.53c\nimages=9223372036854775807\n";
  for (const char* name : {"a1.tif", "a2.tif", "a3.tif"})
    writeTiff(files.directory() / name, randomVolume(kStackDims, VoxelType::u8, 53), 0, 1, layout);
  for (const ListedVolume& volume : volumesIn(files.directory())) {
    EXPECT_GT(volume.dims->z, 0);
    EXPECT_EQ(volume.bytes(), 21u * 19 * static_cast<std::uint64_t>(volume.dims->z));
  }
  ListedVolume huge;
  huge.dims = Extent3{INT32_MAX, INT32_MAX, INT32_MAX};
  huge.type = VoxelType::f64;
  EXPECT_EQ(huge.bytes(), UINT64_MAX);
}

}  // namespace
}  // namespace kiln::test
