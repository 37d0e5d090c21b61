// Slices: numbered files, colours, and the sheet of three. Known: voxels have the value 2x + 3y + 5z.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <tuple>

#include "image/file/image_file.h"
#include "image/srgb.h"
#include "scene/transfer/named_color_maps.h"
#include "support/files/nifti_files.h"
#include "support/system/tool_test.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

class SlicesCli : public ToolTest {
 protected:
  SlicesCli() : ToolTest("slices_") {}
  void SetUp() override {
    const DenseVolume volume = fill({{20, 15, 10}}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
      return static_cast<double>(2 * i + 3 * j + 5 * k);
    });
    std::filesystem::rename(makeStore(volume, "slices_source"), in("v.kiln"));
  }
  bool there(const std::string& name) const { return std::filesystem::exists(directory_ / name); }
};

TEST_F(SlicesCli, NameWithANumber_drawsEverySlice) {
  done({"slice", in("v.kiln"), "-o", in("all_##.png")});
  for (int z = 0; z < 10; ++z) EXPECT_TRUE(there("all_0" + std::to_string(z) + ".png")) << z;
  EXPECT_FALSE(there("all_10.png"));
  done({"slice", in("v.kiln"), "-o", in("some_#.exr"), "--axis", "x", "--index", "4-12x4", "--window", "50,100"});
  for (const int x : {4, 8, 12}) {
    const Image slice = readImage(in("some_" + std::to_string(x) + ".exr"));
    ASSERT_EQ(slice.width, 15);
    ASSERT_EQ(slice.height, 10);
    // Column 2 is y = 2, the lowest row z = 0: the grey is the value over 100.
    EXPECT_NEAR(slice.pixel(2, 9)[0], linearFromSrgb((2 * x + 6) / 100.0), 2e-3) << x;
  }
  EXPECT_FALSE(there("some_5.exr"));
}

TEST_F(SlicesCli, ColourMap_coloursTheWindow) {
  done({"slice", in("v.kiln"), "-o", in("c.exr"), "--index", "0", "--window", "50,100", "--colormap", "viridis"});
  const Image slice = readImage(in("c.exr"));
  const glm::dvec3 color = namedColorMap("viridis").at((2 * 7 + 3 * 4) / 100.0);
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_NEAR(slice.pixel(7, 4)[channel], linearFromSrgb(color[channel]), 2e-3) << channel;
}

// Known: voxels of the source are labels, of which 2x + 3y + 5z = 3 lies at (0, 1, 0). A palette has no grey.
TEST_F(SlicesCli, Labels_haveTheirColours) {
  done({"export", in("v.kiln"), in("l.nrrd")});
  done({"convert", in("l.nrrd"), in("l.kiln"), "--labels"});
  const auto isGrey = [](const float* color) { return color[0] == color[1] && color[1] == color[2]; };
  done({"slice", in("l.kiln"), "-o", in("l.exr"), "--index", "0"});
  const Image slice = readImage(in("l.exr"));
  EXPECT_FALSE(isGrey(slice.pixel(0, 1)));
  done({"slice", in("l.kiln"), "-o", in("w.exr"), "--index", "0", "--window", "50,100"});
  EXPECT_TRUE(isGrey(readImage(in("w.exr")).pixel(0, 1)));
  // A palette has no colours for labels that are far apart and not counted.
  writeText(in("far.nrrd"),
            "NRRD0004\ntype: uint32\ndimension: 3\nsizes: 2 2 2\nencoding: text\n\n0 1 100000 1 0 1 0 1\n");
  done({"convert", in("far.nrrd"), in("far.kiln"), "--labels"});
  done({"slice", in("far.kiln"), "-o", in("far.exr")});
  done({"slice", in("l.kiln"), "-o", in("s.exr"), "--sheet", "--at", "0,1,0"});
  // A voxel of a small volume is 9 x 9 pixels of a sheet.
  const Image sheet = readImage(in("s.exr"));
  // A plane along z has the pixels of the slice.
  done({"slice", in("l.kiln"), "-o", in("p.exr"), "--plane", "0,0,1,0"});
  const Image plane = readImage(in("p.exr"));
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_EQ(plane.pixel(7, 4)[channel], slice.pixel(7, 4)[channel]) << channel;
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_EQ(sheet.pixel(8 + 7 * 9 + 4, 8 + 14 + 4 * 9 + 4)[channel], slice.pixel(7, 4)[channel]) << channel;
}

// Known: bins of labels are narrower than pixels here, and labels have no window. The colours are those of bars and
// window lines, below the first panel and right of the second.
TEST_F(SlicesCli, SheetOfLabels_hasBarsAndNoWindow) {
  std::string voxels;
  for (int i = 0; i < 64; ++i) voxels += i == 0 ? "60000 " : i % 2 == 0 ? "7 " : "0 ";
  writeText(in("few.nrrd"), "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 4 4 4\nencoding: text\n\n" + voxels + "\n");
  done({"convert", in("few.nrrd"), in("few.kiln"), "--labels"});
  done({"slice", in("few.kiln"), "-o", in("few.exr"), "--sheet"});
  const Image sheet = readImage(in("few.exr"));
  int bars = 0, lines = 0;
  for (int y = sheet.height / 2 + 30; y < sheet.height; ++y) {
    for (int x = 204; x < sheet.width; ++x) {
      const float red = sheet.pixel(x, y)[0], blue = sheet.pixel(x, y)[2];
      bars += std::abs(red - linearFromSrgb(0.45)) < 2e-3 && std::abs(blue - linearFromSrgb(0.58)) < 2e-3;
      lines += std::abs(red - linearFromSrgb(0.95)) < 2e-3 && std::abs(blue - linearFromSrgb(0.2)) < 2e-3;
    }
  }
  EXPECT_GT(bars, 120);
  EXPECT_EQ(lines, 0);
}

// The first panel is the slice along z, 8 pixels from the left, below a caption of 14 pixels; a voxel has 9 x 9 pixels.
TEST_F(SlicesCli, Sheet_showsTheSlicesThroughAVoxel) {
  const ToolResult result =
      done({"slice", in("v.kiln"), "-o", in("s.exr"), "--sheet", "--at", "12,3,4", "--window", "50,100"});
  EXPECT_NE(result.out.find("through voxel 12,3,4 with the value 53"), std::string::npos) << result.out;
  const Image sheet = readImage(in("s.exr"));
  EXPECT_NEAR(sheet.pixel(8 + 5 * 9 + 4, 8 + 14 + 9 * 9 + 4)[0], linearFromSrgb((2 * 5 + 3 * 9 + 5 * 4) / 100.0), 2e-3);
  // The crosshair runs through row 3, but for its middle.
  EXPECT_NEAR(sheet.pixel(8 + 9, 8 + 14 + 3 * 9 + 4)[0], linearFromSrgb(242 / 255.0), 2e-3);
  EXPECT_NEAR(sheet.pixel(8 + 12 * 9 + 4, 8 + 14 + 3 * 9 + 4)[0], linearFromSrgb(0.53), 2e-3);
}

// The plane x + z = 9, seen along its normal: the middle of the volume, with z up, has the value 2x + 3y + 5z.
TEST_F(SlicesCli, Plane_isDrawnWhereItWasAsked) {
  const ToolResult result =
      done({"slice", in("v.kiln"), "-o", in("o.exr"), "--plane", "1,0,1,-9", "--window", "50,100", "--mode", "mip"});
  EXPECT_NE(result.out.find("pixels of 1, 1 sample across the slice"), std::string::npos) << result.out;
  const Image slice = readImage(in("o.exr"));
  EXPECT_EQ(slice.width, 15);
  // The middle row is 4.5,y,4.5; right is -y.
  EXPECT_NEAR(slice.pixel(12, slice.height / 2)[0], linearFromSrgb((3 * 2 + 7 * 4.5) / 100.0), 0.03);
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--plane", "1,0,1"}, 2, "NX,NY,NZ,OFFSET");
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--plane", "1,0,1,40"}, 2, "beside the volume");
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--plane", "1,0,1,-9", "--axis", "x"}, 2, "--axis");
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--thickness", "3"}, 2, "--plane");
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--pixel", "3"}, 2, "--plane");
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--plane", "1,0,1,-9", "--pixel", "1e-6"}, 2, "--pixel");
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--plane", "1,0,1,-9", "--mode", "composite"}, 2, "minip");
  refused({"slice", in("v.kiln"), "-o", in("o.png"), "--plane", "1,0,1,-9", "--mode", "attenuated-mip"}, 2, "minip");
}

TEST_F(SlicesCli, VolumeFile_isConvertedBesideIt) {
  writeText(in("a.raw"), "abcdefghijklmnopqrstuvwx");  // 2 x 3 x 4 voxels
  done({"slice", in("a.raw"), "-o", in("a.png"), "--dims", "2,3,4", "--type", "u8"});
  EXPECT_TRUE(there("a.raw.kiln/manifest.json"));
  done({"gallery", in("a.raw"), "-o", in("g.png"), "--dims", "2,3,4", "--type", "u8", "--tf", "grayscale"});
  EXPECT_TRUE(there("g.png"));
  // A changed file has a new store, whichever command made the old one. Known: equal voxels have equal pictures.
  const std::string voxels = "abcdefghijklmnopqrstuvwx", turned(voxels.rbegin(), voxels.rend());
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"gallery", "--thumbnail", "32"}, {"slice"}, {"render", "--size", "64x64"}}) {
    const auto drawn = [&](const std::string& bytes) {
      writeText(in("a.raw"), bytes);
      std::vector<std::string> words = {command[0], in("a.raw"), "-o", in("c.png"), "--dims", "2,3,4", "--type", "u8"};
      words.insert(words.end(), command.begin() + 1, command.end());
      done(words);
      return readImage(in("c.png")).rgba;
    };
    const auto first = drawn(voxels);
    EXPECT_FALSE(drawn(turned) == first) << command[0];
    EXPECT_TRUE(drawn(voxels) == first) << command[0];
  }
  refused({"slice", in("a.raw"), "-o", in("a.raw.kiln/b.png"), "--dims", "2,3,4", "--type", "u8"}, 2, "a.raw.kiln");
}

// The mark is the patient's upper right front corner: in RAS, the greatest x, y and z.
TEST_F(SlicesCli, NiftiFiles_areDrawnAsRadiologyDrawsThem) {
  constexpr int kX = 40, kY = 50, kZ = 60;
  const auto value = [](int r, int a, int s) {
    return static_cast<std::uint8_t>(r >= kX - 4 && a >= kY - 4 && s >= kZ - 4 ? 255 : r + a + s);
  };
  NiftiHeader upright;
  upright.dim = {3, kX, kY, kZ, 1, 1, 1, 1};
  upright.sform_code = 1;
  upright.srow = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  NiftiHeader turned = upright;  // x grows to the front, y to the feet, z to the left
  turned.dim = {3, kY, kZ, kX, 1, 1, 1, 1};
  turned.srow = {0, 0, -1, kX - 1, 1, 0, 0, 0, 0, -1, 0, kZ - 1};
  Bytes in_order, permuted;
  for (int k = 0; k < kZ; ++k)
    for (int j = 0; j < kY; ++j)
      for (int i = 0; i < kX; ++i) in_order.push_back(value(i, j, k));
  for (int k = 0; k < kX; ++k)
    for (int j = 0; j < kZ; ++j)
      for (int i = 0; i < kY; ++i) permuted.push_back(value(kX - 1 - k, i, kZ - 1 - j));
  writeBytes(in("upright.nii"), niftiFile(upright, in_order));
  writeBytes(in("turned.nii"), niftiFile(turned, permuted));
  for (const auto& [plane, upright_index, turned_index] :
       {std::tuple{"axial", "59", "0"}, {"coronal", "49", "49"}, {"sagittal", "39", "0"}}) {
    const auto drawn = [&](const std::string& file, const std::string& index) {
      const ToolResult result = done({"slice", in(file), "-o", in("n.png"), "--axis", plane, "--index", index,
                                      "--window", "127.5,255", "--no-letters"});
      EXPECT_NE(result.out.find(std::string("pixels, ") + plane), std::string::npos) << result.out;
      return readImage(in("n.png"));
    };
    const Image image = drawn("upright.nii", upright_index);
    EXPECT_TRUE(image.rgba == drawn("turned.nii", turned_index).rgba) << plane;
    EXPECT_EQ(image.pixel(3, 3)[0], 1) << plane;
    for (const auto& [x, y] :
         {std::pair{4, 4}, {image.width - 1, 0}, {0, image.height - 1}, {image.width - 1, image.height - 1}})
      EXPECT_LT(image.pixel(x, y)[0], 0.5f) << plane << " " << x << " " << y;
  }
  for (const char* file : {"upright.nii", "turned.nii"})
    done({"slice", in(file), "-o", in(std::string(file) + ".png"), "--sheet"});
  // The panels are equal to the bit, but for the captions: they name voxels.
  const Image a = readImage(in("upright.nii.png")), b = readImage(in("turned.nii.png"));
  ASSERT_EQ(a.width, b.width);
  for (int y = 8 + 14; y < 8 + 14 + kZ - 10; ++y) {
    for (int x = 8; x < 8 + kX + 8 + kY; ++x) ASSERT_EQ(a.pixel(x, y)[0], b.pixel(x, y)[0]) << x << " " << y;
  }
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--axis", "axial"}, 2, "--orient");
}

TEST_F(SlicesCli, WrongRequests_areOneLine) {
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--axis", "w"}, 2, "axial, coronal or sagittal");
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--index", "0-3"}, 2, "p_####.png");
  refused({"slice", in("v.kiln"), "-o", in("p_#.png"), "--index", "0-10"}, 2, "10 is not between 0 and 9");
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--colormap", "rainbow"}, 2, "viridis");
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--at", "1,1,1"}, 2, "--sheet");
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--sheet", "--at", "20,1,1"}, 2, "19,14,9");
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--sheet", "--index", "1"}, 2, "--index");
  refused({"slice", in("v.kiln"), "-o", in("p.png"), "--sheet", "--memory", "64K"}, 1,
          "--memory: 64.0 KiB is too little: a sheet of three slices");
}

}  // namespace
}  // namespace kiln::test
