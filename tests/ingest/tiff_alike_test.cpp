// Pages of one volume are alike in all that decides their bytes. Known because types that become the same voxels
// differ in the size of a stored value, and because the test writes every description.
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/tiff_files.h"

namespace kiln::test {
namespace {

struct StoredPage {
  std::string name;
  VoxelType written;
  int sample_format;
};

void writePage(const std::filesystem::path& path, const StoredPage& page) {
  TiffLayout layout;
  layout.sample_format = page.sample_format;
  writeTiff(path, randomVolume(kStackDims, page.written, 41), 0, 1, layout);
}

TEST(TiffAlike, PagesOfOneVoxelTypeAndTwoSizes_AreRefusedByTheirStoredTypes) {
  const StoredPage i32{"i32", VoxelType::i32, 0}, i64{"i64", VoxelType::f64, 2}, f32{"f32", VoxelType::f32, 0},
      f16{"f16", VoxelType::u16, 3};
  for (const auto& [first, second] : {std::pair{i32, i64}, {i64, i32}, {f32, f16}, {f16, f32}}) {
    SCOPED_TRACE(first.name + " then " + second.name);
    const ForeignFiles files;
    writePage(files.directory() / "s1.tif", first);
    writePage(files.directory() / "s2.tif", second);
    expectRefused(files.directory(), ErrorCode::kFormat,
                  "s2.tif: page 1: slice 1 is 21 x 19 of " + second.name +
                      ", but the first, in s1.tif, is 21 x 19 of " + first.name);
  }
}

std::string omePixels(const std::string& order, const std::string& inside) {
  return "<OME x=\"y\"><Pixels DimensionOrder=\"" + order + "\" SizeC=\"2\" SizeZ=\"2\" SizeT=\"1\">" + inside +
         "</Pixels></OME>";
}

// Known: with a repeated axis the steps between images would lead beyond the last one.
TEST(TiffAlike, OrderThatRepeatsAnAxis_IsRefused) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 42);
  const auto path = files.directory() / "a.tif";
  SourceOptions options;
  options.channel = "1";
  for (const char* order : {"XYCCZT", "XYZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZCT"}) {
    TiffLayout layout;
    layout.description = omePixels(order, "");
    writeTiff(path, volume, 0, 4, layout);
    expectRefused(path, ErrorCode::kUnsupported, "repeats an axis", options);
  }
}

// The description is several megabytes long: each element is parsed once.
TEST(TiffAlike, ManyPlacesOfPlanes_AreReadOnce) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 43);
  std::string places;
  for (int i = 0; i < 60000; ++i)
    places += "<TiffData IFD=\"" + std::to_string(i % 4) + "\" FirstZ=\"" + std::to_string(i % 2) + "\" FirstC=\"" +
              std::to_string(i / 2 % 2) + "\" PlaneCount=\"1\"/>";
  TiffLayout layout;
  layout.description = omePixels("XYZCT", places);
  writeTiff(files.directory() / "a.tif", volume, 0, 4, layout);
  SourceOptions options;
  options.channel = "1";
  expectReadsBack(
      volume.slices({2, 3}), [&] { return openSource(files.directory() / "a.tif", options); }, 44);
}

}  // namespace
}  // namespace kiln::test
