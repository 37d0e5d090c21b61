// Masks, colours of another volume and channels as users see them: equal options and jobs, statistics, resumed frames
// and refusals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
using Json = nlohmann::json;

class CompanionsCli : public ToolTest {
 protected:
  CompanionsCli() : ToolTest("companions_") {}
  void SetUp() override {
    done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"});
    writeMask(3, 7);
    done({"convert", in("m.nrrd"), in("m.kiln"), "--labels", "--brick-size", "8"});
  }
  // Labels of the lower and the upper half of the head's box.
  void writeMask(char lower, char upper) const {
    writeText(in("m.nrrd"),
              "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 20 20 20\nspace: left-posterior-superior\n"
              "space directions: (14.4,0,0) (0,14.4,0) (0,0,12.65)\nspace origin: (-136.8,-136.8,1613.4)\n"
              "space units: \"mm\" \"mm\" \"mm\"\nencoding: raw\n\n" +
                  std::string(4000, lower) + std::string(4000, upper));
  }
  ZeroPages<float> drawn(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "render");
    arguments.insert(arguments.end(), {"-o", in("d.exr"), "--size", "40x36", "--exr-type", "float"});
    done(arguments);
    return readImage(in("d.exr")).rgba;
  }
};

// Known because an option and the job's key are equivalent, and the header stores the job.
TEST_F(CompanionsCli, OptionsAreTheJobsKeys) {
  const std::string mask = in("m.kiln") + ":3,9", colors = in("m.kiln");
  const ZeroPages<float> plain = drawn({in("h.kiln"), "--tf", "ct-skin"});
  const ZeroPages<float> masked = drawn({in("h.kiln"), "--tf", "ct-skin", "--mask", mask});
  const ZeroPages<float> both = drawn({in("h.kiln"), "--tf", "ct-skin", "--mask", mask, "--color-by", colors});
  EXPECT_NE(plain, masked);
  EXPECT_NE(masked, both);
  EXPECT_NE(both, ZeroPages<float>(both.size()));
  writeText(in("again.json"), readImageText(in("d.exr")).at("kiln:job"));
  EXPECT_EQ(drawn({in("again.json")}), both);
  writeText(in("job.json"), R"({"kiln": 2, "volume": "h.kiln", "transferFunction": "ct-skin",
      "mask": {"volume": "m.kiln", "labels": [3, 9]}, "colorBy": {"volume": "m.kiln"}})");
  EXPECT_EQ(drawn({in("job.json")}), both);
  // Amounts without a function have the colours of a map.
  const auto coloured = [&](const std::string& by) {
    return drawn({in("h.kiln"), "--tf", "ct-skin", "--color-by", by});
  };
  EXPECT_EQ(coloured(in("h.kiln")), coloured(in("h.kiln") + ":fire"));
  // Listing a label again changes nothing.
  EXPECT_EQ(drawn({in("h.kiln"), "--tf", "ct-skin", "--mask", in("m.kiln") + ":3,9,3"}), masked);
  writeText(in("two.json"), R"({"kiln": 2, "volumes": [{"volume": "h.kiln", "transferFunction": "ct-skin",
      "mask": {"volume": "m.kiln", "labels": [3, 9]}, "colorBy": {"volume": "m.kiln"}}]})");
  EXPECT_NE(drawn({in("two.json")}), ZeroPages<float>(both.size()));
}

TEST_F(CompanionsCli, StatisticsCountWhatTheMaskHides) {
  drawn({in("h.kiln"), "--mask", in("m.kiln") + ":3", "--level", "0", "--fit", "box", "--stats", in("s.json")});
  const Json stats = Json::parse(readFile(in("s.json")));
  EXPECT_GT(stats["bricks"]["masked"].get<int>() + stats["bricks"]["emptied"].get<int>(), 0);
  EXPECT_GT(stats["companions"]["read"], 0);
  EXPECT_LT(stats["bricks"]["read"], stats["bricks"]["total"]);
  done({"render", in("h.kiln"), "--mask", in("m.kiln") + ":3", "--level", "0", "--dry-run", "--stats", in("dry.json")});
  const Json dry = Json::parse(readFile(in("dry.json")));
  EXPECT_EQ(dry["bricks"]["interesting"], stats["bricks"]["interesting"]);
}

// A frame is not taken for the job's if its mask became another volume.
TEST_F(CompanionsCli, FramesOfAnotherMask_areNotTaken) {
  const std::vector<std::string> draw = {"render",   in("h.kiln"),  "--mask",  in("m.kiln") + ":3",
                                         "-o",       in("f_#.png"), "--size",  "40x36",
                                         "--frames", "1",           "--resume"};
  done(draw);
  const std::vector<std::byte> before = readFile(in("f_1.png"));
  done(draw);
  EXPECT_EQ(readFile(in("f_1.png")), before);
  writeMask(7, 3);
  done({"convert", in("m.nrrd"), in("m.kiln"), "--labels", "--brick-size", "8", "--overwrite"});
  refused(draw, 1, "is a picture of another job");
  EXPECT_EQ(readFile(in("f_1.png")), before);
}

// The header holds the function that a file had, so a picture shows when the file has changed.
TEST_F(CompanionsCli, FramesOfAnotherFunctionOfColours_areNotTaken) {
  const auto write_map = [&](const char* red) {
    writeText(in("map.json"), fmt::format(R"({{"kiln": 2, "points": [{{"value": 0, "color": "navy", "opacity": 1}},
        {{"value": 9, "color": [{}, 0, 0], "opacity": 1}}]}})",
                                          red));
  };
  const auto drawTwice = [&](const std::vector<std::string>& input) {
    std::vector<std::string> draw = {"render", "-o", in("f.png"), "--size", "16x16", "--resume"};
    draw.insert(draw.begin() + 1, input.begin(), input.end());
    write_map("1");
    done(draw);
    const auto time = std::filesystem::last_write_time(in("f.png"));
    done(draw);
    EXPECT_EQ(std::filesystem::last_write_time(in("f.png")), time);
    write_map("0.5");
    refused(draw, 1, "is a picture of another job: ");
    std::filesystem::remove(in("f.png"));
  };
  drawTwice({in("h.kiln"), "--color-by", in("h.kiln") + ":" + in("map.json")});
  writeText(in("two.json"), R"({"kiln": 2, "volumes": [
      {"volume": "h.kiln", "colorBy": {"volume": "h.kiln", "transferFunction": "./map.json"}}]})");
  drawTwice({in("two.json")});
}

TEST_F(CompanionsCli, WrongUsesAreRefused) {
  const auto refusedWith = [&](const std::vector<std::string>& more, const char* text) {
    std::vector<std::string> arguments = {"render", in("h.kiln"), "-o", in("r.png"), "--size", "40x36"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    refused(arguments, 2, text);
  };
  refusedWith({"--mask", in("h.kiln") + ":3"}, "holds amounts");
  refusedWith({"--mask", in("m.kiln") + ":3", "--lattice", "voxel"},
              "--mask: needs --lattice pixel, or several volumes");
  refusedWith({"--color-by", in("m.kiln"), "--mode", "mip"}, "--color-by: needs --mode composite (found --mode mip)");
  refusedWith({"--channel-colors", "red:green", "--mode", "mip"}, "--channel-colors: needs");
  refusedWith({"--channel-colors", "red:green:blue", "--mode", "mip", "--add", in("h.kiln")}, "at most one for each");
}

// Known because an option and the job's key are equivalent, and because the colours of two channels differ.
TEST_F(CompanionsCli, ChannelsHaveTheirColours) {
  done({"convert", "phantom:brain:30x30x30", in("b.kiln"), "--brick-size", "16"});
  const ZeroPages<float> automatic = drawn({in("h.kiln"), "--add", in("b.kiln"), "--mode", "mip"});
  const ZeroPages<float> chosen =
      drawn({in("h.kiln"), "--add", in("b.kiln"), "--mode", "mip", "--channel-colors", "magenta:#0f0"});
  float red = 0, green = 0;
  for (std::size_t at = 0; at < automatic.size(); at += 4) {
    ASSERT_EQ(automatic[at], automatic[at + 2]) << "magenta and green";
    red = std::max(red, automatic[at]), green = std::max(green, automatic[at + 1]);
  }
  EXPECT_GT(red, 0.1f);
  EXPECT_GT(green, 0.1f);
  // "green" of CSS is darker than the channel's.
  EXPECT_EQ(automatic, chosen);
  writeText(in("again.json"), readImageText(in("d.exr")).at("kiln:job"));
  EXPECT_EQ(drawn({in("again.json")}), chosen);
  writeText(in("job.json"), R"({"kiln": 2, "mode": "mip", "channelColors": ["magenta", "#0f0"],
      "volumes": [{"volume": "h.kiln"}, {"volume": "b.kiln"}]})");
  EXPECT_EQ(drawn({in("job.json")}), chosen);
  EXPECT_NE(drawn({in("h.kiln"), "--add", in("b.kiln"), "--mode", "attenuated-mip", "--attenuation", "0.2"}), chosen);
}

}  // namespace
}  // namespace kiln::test
