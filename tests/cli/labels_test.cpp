// Label volumes as users see them: converted, counted, coloured by a palette, by ITK-SNAP's files or by a job, alone
// and inside another volume; and refused uses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "image/file/image_file.h"
#include "support/files/zarr_files.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {

constexpr const char* kSnapFile = R"(# ITK-SnAP Label Description File
    0     0    0    0        0  0  0    "Clear Label"
    3   255    0    0        1  1  1    "box"
    9     0    0  255      0.6  1  1    "ball"
)";

// Label 200 has no entry in kSnapFile.
void expectNamedOnce(const ToolResult& result) {
  const std::string said = result.out + result.err;
  const std::size_t at = said.find("label 200 is in the volume");
  ASSERT_NE(at, std::string::npos) << said;
  EXPECT_EQ(said.find("label 200", at + 1), std::string::npos) << said;
}

class LabelsCli : public ToolTest {
 protected:
  LabelsCli() : ToolTest("labels_") {}
  // A box of 12 x 12 x 12 voxels of 3, a ball of 9, a voxel of 200, in the head's own space.
  void SetUp() override {
    writeRaw(in("l.raw"));
    convertLabels("l.kiln");
  }
  void writeRaw(const std::string& path) const {
    std::string voxels(36 * 30 * 32, '\0');
    for (int z = 0; z < 32; ++z) {
      for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 36; ++x) {
          const bool box = x >= 4 && x < 16 && y >= 6 && y < 18 && z >= 8 && z < 20;
          const bool ball = (x - 24) * (x - 24) + (y - 15) * (y - 15) + (z - 16) * (z - 16) < 64;
          voxels[static_cast<std::size_t>((z * 30 + y) * 36 + x)] = box ? '\3' : ball ? '\11' : '\0';
        }
      }
    }
    voxels[0] = static_cast<char>(200);
    writeText(path, voxels);
  }
  void convertLabels(const std::string& name, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"convert", in("l.raw"), in(name),   "--dims",       "36,30,32",
                                          "--type",  "u8",        "--labels", "--brick-size", "8"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    done(arguments);
  }
  ZeroPages<float> drawn(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "render");
    for (const char* more : {"-o", "@", "--size", "60x50", "--exr-type", "float"})
      arguments.push_back(std::string(more) == "@" ? in("d.exr") : more);
    done(arguments);
    return readImage(in("d.exr")).rgba;
  }
};

TEST_F(LabelsCli, AreCountedAndVerified) {
  const std::string info = done({"info", in("l.kiln")}).out;
  EXPECT_NE(info.find("class labels"), std::string::npos) << info;
  EXPECT_NE(info.find("       3  1728 voxels"), std::string::npos) << info;
  EXPECT_NE(info.find("     200  1 voxel"), std::string::npos) << info;
  EXPECT_NE(info.find("4 that have voxels"), std::string::npos) << info;
  done({"verify", in("l.kiln")});
}

// Known because no byte of a store may depend on threads, memory or ranks.
TEST_F(LabelsCli, AreTheSameStoreForThreadsMemoryAndRanks) {
  const auto bytes = [&](const std::string& name) {
    auto files = filesOf(in(name));
    files.erase("manifest.json");  // contains the command
    return files;
  };
  const auto expected = bytes("l.kiln");
  convertLabels("one.kiln", {"--threads", "1", "--memory", "2M"});
  EXPECT_EQ(bytes("one.kiln"), expected);
  if (!canRunRanks()) GTEST_SKIP() << "Kiln is built without MPI, or mpirun is not there";
  ToolOptions three;
  three.ranks = 3;
  done(
      {"convert", in("l.raw"), in("ranks.kiln"), "--dims", "36,30,32", "--type", "u8", "--labels", "--brick-size", "8"},
      three);
  EXPECT_EQ(bytes("ranks.kiln"), expected);
}

// A file of ITK-SNAP's and a job's list are equivalent, and the header stores the job.
TEST_F(LabelsCli, AFileOfItkSnapsIsAJobsList) {
  writeText(in("l.txt"), kSnapFile);
  const ZeroPages<float> by_file = drawn({in("l.kiln"), "--tf", in("l.txt")});
  writeText(in("again.json"), readImageText(in("d.exr")).at("kiln:job"));
  writeText(in("job.json"), R"({"kiln": 2, "volume": "l.kiln", "output": "j.exr", "image": {"width": 60, "height": 50},
    "transferFunction": {"colorSpace": "srgb", "labels": [{"label": 9, "name": "ball", "color": [0, 0, 1], "opacity": 0.6},
                                                          {"label": 3, "color": [1, 0, 0]}]}})");
  EXPECT_TRUE(by_file == drawn({in("job.json")}));
  EXPECT_TRUE(by_file == drawn({in("again.json")}));
  // tf prints the list, from the file alone and for the volume.
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"tf", in("l.txt"), "--json"}, {"tf", in("l.kiln"), "--tf", in("l.txt"), "--json"}}) {
    writeText(in("tf.json"), done(command).out);
    EXPECT_TRUE(by_file == drawn({in("l.kiln"), "--tf", in("tf.json")}));
  }
  float red = 0, green = 0, blue = 0;
  for (std::size_t i = 0; i < by_file.size(); i += 4)
    red = std::max(red, by_file[i]), green = std::max(green, by_file[i + 1]), blue = std::max(blue, by_file[i + 2]);
  EXPECT_GT(red, 0.5f);
  EXPECT_GT(blue, 0.3f);
  EXPECT_LT(green, 0.25f);  // from highlights, which are white
  EXPECT_FALSE(by_file == drawn({in("l.kiln")})) << "the palette is of other colours";
  const std::string listed = done({"tf", in("l.txt")}).out;
  EXPECT_NE(listed.find("ball"), std::string::npos) << listed;
}

TEST_F(LabelsCli, WhatIsNotSaidIsNotDrawnAndNamedOnce) {
  writeText(in("l.txt"), kSnapFile);
  expectNamedOnce(
      done({"render", in("l.kiln"), "-o", in("w_#.png"), "--size", "30x30", "--tf", in("l.txt"), "--turntable", "3"}));
  EXPECT_EQ(done({"render", in("l.kiln"), "-o", in("p.png"), "--size", "30x30"}).err.find("warning"),
            std::string::npos);
}

// Only rank 0 prints the label without an entry.
TEST_F(LabelsCli, RanksNameOnceWhatIsNotSaid) {
  if (!canRunRanks()) GTEST_SKIP() << "Kiln is built without MPI, or mpirun is not there";
  writeText(in("l.txt"), kSnapFile);
  ToolOptions options;
  options.ranks = 3;
  expectNamedOnce(
      done({"render", in("l.kiln"), "-o", in("w_#.png"), "--size", "30x30", "--tf", in("l.txt"), "--turntable", "3"},
           options));
}

TEST_F(LabelsCli, StandInAnotherVolume) {
  writeText(in("l.txt"), kSnapFile);
  done({"convert", "phantom:head:36x30x32", in("h.kiln"), "--brick-size", "16"});
  const std::vector<std::string> head = {in("h.kiln"), "--tf", "ct-bone"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), head.begin(), head.end());
    return drawn(more);
  };
  const ZeroPages<float> both = with({"--add", in("l.kiln"), "--add-tf", in("l.txt")});
  EXPECT_FALSE(both == drawn(head));
  EXPECT_FALSE(both == with({"--add", in("l.kiln")})) << "the palette";
}

TEST_F(LabelsCli, WhatMakesNoSenseIsRefused) {
  writeText(in("l.txt"), kSnapFile);
  done({"convert", "phantom:head:20x20x20", in("h.kiln")});
  const auto render = [&](const std::string& store, const std::vector<std::string>& more, const std::string& mention) {
    std::vector<std::string> arguments = {"render", in(store), "-o", in("x.png")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    refused(arguments, 2, mention);
  };
  render("h.kiln", {"--tf", in("l.txt")}, "convert it with --labels");
  render("l.kiln", {"--tf", "ct-bone"}, "the volume's values are labels");
  render("l.kiln", {"--window", "1,2"}, "labels are names");
  render("l.kiln", {"--mode", "mip"}, "--mode");
  writeText(in("bad.txt"), std::string(kSnapFile) + "red 255 0 0 1 1 1 \"x\"\n");
  refused({"render", in("l.kiln"), "-o", in("x.png"), "--tf", in("bad.txt")}, 1, "bad.txt: line 5");
  writeText(in("f.raw"), std::string(4 * 8, '\0'));
  refused({"convert", in("f.raw"), in("f.kiln"), "--dims", "2,2,2", "--type", "f32", "--labels"}, 2, "whole numbers");
  refused({"convert", in("l.raw"), in("f.kiln"), "--dims", "36,30,32", "--type", "u8", "--labels", "--half"}, 2,
          "--half");
  refused({"convert", in("l.raw"), in("l.kiln"), "--dims", "36,30,32", "--type", "u8", "--brick-size", "8", "--resume"},
          1, "is a store of labels");
}

TEST_F(LabelsCli, OfAHeaderThatCannotBeDrawn_AreWarnedOf) {
  writeBelow(in("a.zarr/.zgroup"), R"({"zarr_format": 2})");
  writeBelow(in("a.zarr/.zattrs"), R"({"image-label": {"version": "0.4"}, "multiscales": [{"version": "0.4",
      "axes": [{"name": "z", "type": "space"}, {"name": "y", "type": "space"}, {"name": "x", "type": "space"}],
      "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]}]}]})");
  writeZarr(in("a.zarr/0"), randomVolume(kFewVoxels, VoxelType::u32, 7));
  EXPECT_NE(done({"convert", in("a.zarr"), in("a.kiln")}).err.find("cannot be drawn"), std::string::npos);
}

}  // namespace
}  // namespace kiln::test
