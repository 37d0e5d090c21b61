// Several volumes in a picture as users see them: equivalent options and jobs, resumed frames, memory, and refusals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

class VolumesCli : public ToolTest {
 protected:
  VolumesCli() : ToolTest("volumes_") {}
  void SetUp() override {
    done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"});
    done({"convert", "phantom:engine:30x40x20", in("e.kiln"), "--brick-size", "32"});
  }

  // Writes a job with two volumes; `first` and `second` are their additional keys.
  void writeJob(const std::string& first, const std::string& second, const std::string& more = "") const {
    writeText(in("job.json"),
              fmt::format(R"({{"kiln": 2, "volumes": [{{"volume": "h.kiln"{}}}, {{"volume": "e.kiln"{}}}],
      "output": "j.exr", "image": {{"width": 40, "height": 36}}{}}})",
                          first, second, more));
  }
};

// Known because an option and the job's key are equivalent, and the header stores the job.
TEST_F(VolumesCli, OptionsAreTheJobsKeys) {
  done({"render", in("h.kiln"), "-o", in("o.exr"), "--size", "40x36", "--add", in("e.kiln"), "--add-tf", "solid:100",
        "--tf", "ct-bone", "--region", "0,0,0,40,30,40", "--clip", "1,0,0,90", "--exr-type", "float"});
  writeJob(R"(, "transferFunction": "ct-bone", "region": [0, 0, 0, 40, 30, 40])",
           R"(, "transferFunction": "solid:100")",
           R"(, "clip": [{"normal": [1, 0, 0], "offset": 90}], "exr": {"type": "float"})");
  done({"render", in("job.json")});
  const Image by_options = readImage(in("o.exr")), by_job = readImage(in("j.exr"));
  EXPECT_TRUE(by_options.rgba == by_job.rgba);
  EXPECT_NE(by_job.rgba, ZeroPages<float>(by_job.rgba.size()));
  // Each volume changes the picture.
  for (const char* hidden : {"h.kiln", "e.kiln"}) {
    done({"render", in(hidden), "-o", in("one.exr"), "--size", "40x36", "--exr-type", "float"});
    EXPECT_NE(readImage(in("one.exr")).rgba, by_job.rgba);
  }
  writeText(in("again.json"), readImageText(in("j.exr")).at("kiln:job"));
  done({"render", in("again.json"), "-o", in("again.exr"), "--exr-type", "float"});
  EXPECT_TRUE(readImage(in("again.exr")).rgba == by_job.rgba);
}

// Known because a volume's own clipping and shading equal direct settings in the library: a clipped part is not drawn,
// independent of the other volume.
TEST_F(VolumesCli, EachHasItsOwnClippingAndShading) {
  const auto drawn = [&](const std::string& first, const std::string& second) {
    writeJob(first, second);
    done({"render", in("job.json")});
    return readImage(in("j.exr")).rgba;
  };
  const std::string gone = R"(, "clip": [{"normal": [0, 0, 1], "offset": -10000}])",
                    solid = R"(, "transferFunction": "solid:100")";
  const ZeroPages<float> both = drawn("", solid), alone = drawn("", solid + gone), other = drawn(gone, solid);
  EXPECT_NE(both, alone);
  EXPECT_NE(both, other);
  EXPECT_NE(alone, other);
  EXPECT_EQ(alone, drawn("", R"(, "transferFunction": {"points": [{"value": 0, "color": [1, 1, 1], "opacity": 0}]})"));
  EXPECT_NE(both, drawn(R"(, "shading": {"model": "none"})", solid));
}

// Each volume's function has separate keyframes. Existing frames are kept, except frames of other data.
TEST_F(VolumesCli, FramesAreGoneOnWith) {
  writeJob(
      R"(, "transferFunction": {"keyframes": [{"frame": 1, "function": "ct-skin"}, {"frame": 3, "function": "ct-bone"}]})",
      R"(, "transferFunction": {"keyframes": [{"frame": 2, "function": "solid:90"}, {"frame": 4, "function": "solid:120"}]})");
  const std::vector<std::string> draw = {"render", in("job.json"), "-o", in("f_##.png"), "--resume"};
  done(draw);
  const std::string last = readFile(in("f_04.png")).empty() ? "" : in("f_04.png");
  ASSERT_FALSE(last.empty());
  EXPECT_NE(readImage(in("f_01.png")).rgba, readImage(in("f_04.png")).rgba);
  EXPECT_FALSE(fs::exists(in("f_05.png")));
  const ZeroPages<float> third = readImage(in("f_03.png")).rgba;
  fs::remove(in("f_03.png"));
  const ToolResult resumed = done(draw);
  EXPECT_NE((resumed.out + resumed.err).find("1 drawn, 3 kept"), std::string::npos) << resumed.out << resumed.err;
  EXPECT_EQ(readImage(in("f_03.png")).rgba, third);
  done({"convert", "phantom:engine:20x40x20", in("e.kiln"), "--brick-size", "32", "--overwrite"});
  const ToolResult other = runTool(draw);
  EXPECT_EQ(other.exit_code, 1);
  ASSERT_EQ(other.errorLines().size(), 2u) << other.err;
  EXPECT_NE(other.errorLines()[0].find("e.kiln: its patient frame is unknown"), std::string::npos) << other.err;
  EXPECT_NE(other.errorLines()[1].find("is a picture of another job"), std::string::npos) << other.err;
}

// A time series as the second volume, beside a constant first volume. The function uses absolute values, because a
// preset depends on the values of all frames.
TEST_F(VolumesCli, AVolumeMayBeATimeSeries) {
  done({"convert", "phantom:engine:30x40x20", in("t_1.kiln")});
  done({"convert", "phantom:engine:20x20x20", in("t_2.kiln")});
  writeText(in("tf.json"), R"({"unit": 5, "points": [{"value": 90, "color": [1, 1, 1], "opacity": 0},
                                          {"value": 110, "color": [1, 0, 0], "opacity": 0.9}]})");
  done({"render", in("h.kiln"), "--add", in("t_#.kiln"), "--add-tf", in("tf.json"), "-o", in("t_#.png"), "--frames",
        "1-2", "--size", "30x30"});
  EXPECT_NE(readImage(in("t_1.png")).rgba, readImage(in("t_2.png")).rgba);
  done({"render", in("h.kiln"), "--add", in("t_2.kiln"), "--add-tf", in("tf.json"), "-o", in("one.png"), "--size",
        "30x30", "--fit", "box"});
  EXPECT_EQ(readImage(in("one.png")).rgba, readImage(in("t_2.png")).rgba);
}

// The smallest memory printed by a dry run works and draws an equal picture; half of the bricks' memory does not.
TEST_F(VolumesCli, DryRunSaysTheSmallestMemory) {
  writeJob("", "");
  done({"render", in("job.json"), "--dry-run", "--stats", in("cost.json"), "--threads", "1"});
  const Json memory = Json::parse(readTextFile(in("cost.json"), 1 << 20))["memory"];
  const auto smallest = memory["smallest_bytes"].get<std::uint64_t>();
  EXPECT_GT(memory["brick_bytes"].get<std::uint64_t>(), 0u);
  const auto with = [&](std::uint64_t bytes) {
    return std::vector<std::string>{"render",   in("job.json"),       "-o", in("m.png"), "--threads", "1",
                                    "--memory", std::to_string(bytes)};
  };
  done(with(smallest));
  const ZeroPages<float> least = readImage(in("m.png")).rgba;
  done({"render", in("job.json"), "-o", in("n.png")});
  EXPECT_EQ(least, readImage(in("n.png")).rgba);
  refused(with(smallest - memory["brick_bytes"].get<std::uint64_t>() / 2), 1, "of bricks that meet in a tile");
}

TEST_F(VolumesCli, WhatOneVolumeOnlyHasIsRefused) {
  const std::vector<std::string> two = {"render", in("h.kiln"), "-o", in("x.exr"), "--add", in("e.kiln")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), two.begin(), two.end());
    return more;
  };
  refused(with({"--lattice", "voxel"}), 2, "--lattice voxel: draws one volume (found several)");
  refused(with({"--part", "1/2"}), 2, "--part: needs one volume (found several volumes)");
  refused(with({"--level", "9"}), 2, "there is no level 9");
  refused(with({"--add-tf", "auto", "--add-tf", "auto"}), 2, "--add-tf");
  refused({"render", in("h.kiln"), "-o", in("x.exr"), "--add", in("no.kiln")}, 1, "no.kiln");
  const auto job = [&](const std::string& text, const std::string& mention) {
    writeText(in("job.json"), text);
    refused({"render", in("job.json"), "-o", in("x.png")}, 2, mention);
  };
  job(R"({"kiln": 2, "volumes": []})", "volumes: expected a list of at least one volume");
  job(R"({"kiln": 2, "volume": "h.kiln", "volumes": [{"volume": "e.kiln"}]})", "volume: is each volume's own");
  job(R"({"kiln": 2, "volumes": [{"volume": "e.kiln"}], "window": [1, 2]})", "window: is each volume's own");
  job(R"({"kiln": 2, "volumes": [{"volume": "e.kiln"}, {"transferFunction": "auto"}]})",
      "volumes[1].volume: is missing");
  job(R"({"kiln": 2, "volumes": [{"volume": "e.kiln", "windo": [1, 2]}]})",
      "volumes[0].windo: unknown key; did you mean 'window'?");
}

}  // namespace
}  // namespace kiln::test
