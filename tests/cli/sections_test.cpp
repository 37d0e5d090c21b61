// Cut faces that show values, as users see them: equal options and jobs, resumed headers, notes and refusals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {

class SectionsCli : public ToolTest {
 protected:
  SectionsCli() : ToolTest("sections_") {}
  void SetUp() override { done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"}); }
  ZeroPages<float> drawn(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "render");
    arguments.insert(arguments.end(), {"-o", in("d.exr"), "--size", "40x36", "--exr-type", "float"});
    done(arguments);
    return readImage(in("d.exr")).rgba;
  }
  ZeroPages<float> cut(std::vector<std::string> options) const {
    options.insert(options.begin(), {in("h.kiln"), "--tf", "ct-skin", "--clip", "0,1,0,0"});
    return drawn(options);
  }
};

// Known because an option and the job's key are equivalent, and because the header holds the window that was chosen.
TEST_F(SectionsCli, OptionsAreTheJobsKeys) {
  const ZeroPages<float> plain = cut({}), colored = cut({"--section", "tf"}), grey = cut({"--section", "1100,800"});
  const ZeroPages<float> fire = cut({"--section", "fire"});
  EXPECT_NE(plain, colored);
  EXPECT_NE(colored, grey);
  EXPECT_NE(grey, fire);
  EXPECT_EQ(cut({"--section", "off"}), plain);
  writeText(in("again.json"), readImageText(in("d.exr")).at("kiln:job"));
  EXPECT_EQ(drawn({in("again.json")}), plain);
  cut({"--section", "fire"});
  const std::string header = readImageText(in("d.exr")).at("kiln:job");
  EXPECT_NE(header.find("\"window\""), std::string::npos);
  writeText(in("again.json"), header);
  EXPECT_EQ(drawn({in("again.json")}), fire);
  const auto job = [&](const std::string& section) {
    writeText(in("job.json"), fmt::format(R"({{"kiln": 2, "volume": "h.kiln", "transferFunction": "ct-skin",
        "clip": [{{"normal": [0, 1, 0], "offset": 0}}], "section": {}}})",
                                          section));
    return drawn({in("job.json")});
  };
  EXPECT_EQ(job("true"), colored);
  EXPECT_EQ(job("false"), plain);
  EXPECT_EQ(job(R"({"window": [1100, 800]})"), grey);
  EXPECT_EQ(job(R"({"colormap": "fire"})"), fire);
  EXPECT_NE(job(R"({"window": [1100, 800], "opacity": 0.5})"), grey);
}

// The first of two volumes has the option's section; in a job each has its own.
TEST_F(SectionsCli, SeveralVolumesHaveTheirOwn) {
  done({"convert", "phantom:brain:30x30x30", in("b.kiln"), "--brick-size", "16"});
  const ZeroPages<float> plain = cut({"--add", in("b.kiln")}),
                         first = cut({"--add", in("b.kiln"), "--section", "1100,800"});
  EXPECT_NE(plain, first);
  const auto job = [&](const std::string& of_first, const std::string& of_second) {
    writeText(in("job.json"), fmt::format(R"({{"kiln": 2, "clip": [{{"normal": [0, 1, 0], "offset": 0}}], "volumes": [
        {{"volume": "h.kiln", "transferFunction": "ct-skin"{}}}, {{"volume": "b.kiln"{}}}]}})",
                                          of_first, of_second));
    return drawn({in("job.json")});
  };
  const std::string window = R"(, "section": {"window": [1100, 800]})";
  EXPECT_EQ(job("", ""), plain);
  EXPECT_EQ(job(window, ""), first);
  EXPECT_NE(job(window, R"(, "section": true)"), first);
  writeText(in("again.json"), readImageText(in("d.exr")).at("kiln:job"));
  const ZeroPages<float> both = readImage(in("d.exr")).rgba;
  EXPECT_EQ(drawn({in("again.json")}), both);
}

// Known because the default camera is in front of the head, at -y, and the part at y > 0 has its face there.
TEST_F(SectionsCli, SectionWhoseFacesLookAway_isWarnedOfWithAViewThatShowsIt) {
  const auto warning = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"render", in("h.kiln"), "-o", in("w#.png"), "--size", "40x36", "--section", "tf"});
    const std::string err = done(options).err;
    const std::size_t at = err.find("--section: no cut face looks at the camera");
    return at == std::string::npos ? "" : err.substr(at, err.find('\n', at) - at);
  };
  EXPECT_EQ(warning({"--clip", "0,1,0,-2"}), "");
  const std::string away = warning({"--clip", "0,-1,0,2"});
  EXPECT_NE(away.find("(--view back), or keep the other side (--clip 0,1,0,-2)"), std::string::npos) << away;
  const std::string exact = warning({"--clip", "0,-1,0,2.12345678", "--eye", "0,-400,1660"});
  EXPECT_NE(exact.find("(--view back, without --eye), or keep the other side (--clip 0,1,0,-2.12345678)"),
            std::string::npos)
      << exact;
  done({"convert", "phantom:brain:30x30x30", in("b.kiln"), "--brick-size", "16"});
  const std::string several = warning({"--clip", "0,-1,0,2", "--add", in("b.kiln")});
  EXPECT_NE(several, "");
  EXPECT_EQ(several.find("--clip"), std::string::npos) << several;
  EXPECT_EQ(warning({"--clip", "0,-1,0,2", "--view", "back"}), "");
  EXPECT_EQ(warning({"--clip", "0,-1,0,2", "--view", "back", "--projection", "orthographic"}), "");
  EXPECT_NE(warning({"--clip", "0,-1,0,2", "--projection", "orthographic"}), "");
  // One face of two is enough.
  EXPECT_EQ(warning({"--clip", "0,-1,0,2", "--clip", "0,0,-1,1660"}), "");
  const std::string region = warning({"--region", "0,0,0,40,20,40"});
  EXPECT_NE(region.find("(--view back)"), std::string::npos) << region;
  EXPECT_EQ(region.find("--clip"), std::string::npos) << region;
  // A turntable shows the face in some frame.
  EXPECT_EQ(warning({"--clip", "0,-1,0,2", "--turntable", "4"}), "");
}

TEST_F(SectionsCli, PlanesBesideTheVolume_areWarnedOfWithThePlaceOfTheVolume) {
  const auto warns = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"render", in("h.kiln"), "-o", in("w#.png"), "--size", "40x36", "--section", "tf"});
    const std::string err = done(options).err;
    const bool found = err.find("--section: no clip plane and no region cuts the volume") != std::string::npos;
    EXPECT_EQ(found, err.find(", y from ") != std::string::npos) << err;
    return found;
  };
  EXPECT_TRUE(warns({"--clip", "0,1,0,5000"}));
  EXPECT_TRUE(warns({"--clip", "0,1,0,5000", "--turntable", "2"}));
  EXPECT_FALSE(warns({"--clip", "0,1,0,5000", "--clip", "0,1,0,-2"}));
  EXPECT_FALSE(warns({"--clip", "0,-1,0,2"}));
}

TEST_F(SectionsCli, WrongUsesAreRefused) {
  const auto refusedWith = [&](const std::vector<std::string>& more, const char* text) {
    std::vector<std::string> arguments = {"render", in("h.kiln"), "-o", in("r.png"), "--size", "40x36"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    refused(arguments, 2, text);
  };
  refusedWith({"--section", "tf"}, "--section: nothing is cut");
  refusedWith({"--section", "tf", "--clip", "0,1,0,0", "--lattice", "voxel"},
              "--section: needs --lattice pixel, or several volumes");
  refusedWith({"--section", "tf", "--clip", "0,1,0,0", "--mode", "mip"}, "--section: needs --mode composite");
  refusedWith({"--section", "tf", "--clip", "0,1,0,0", "--tf", "iso:1300"}, "--section: surfaces (iso:VALUE)");
  refusedWith({"--section", "teal", "--clip", "0,1,0,0"}, "--section: expected");
  writeText(in("l.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n" + std::string(512, 2));
  done({"convert", in("l.nrrd"), in("l.kiln"), "--labels"});
  refused({"render", in("l.kiln"), "-o", in("r.png"), "--clip", "1,0,0,-3", "--section", "gray"}, 2,
          "--section: labels have no window");
}

}  // namespace
}  // namespace kiln::test
