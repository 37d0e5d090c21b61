// Names that are links, that exist already, or that are special files. Known because each output is at the requested
// name, and all earlier files are still there.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "support/system/tool_test.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

class Names : public ToolTest {
 protected:
  Names() : ToolTest("names_") {}
  void SetUp() override { done({"convert", "phantom:head:48x48x48", in("h.kiln"), "--brick-size", "16"}); }
  // v.raw, of 16^3 bytes.
  void writeRaw() const {
    const DenseVolume volume = ramp({{16, 16, 16}, VoxelType::u8}, 1, 1);
    writeText(in("v.raw"), {reinterpret_cast<const char*>(volume.voxels.data()), volume.voxels.size()});
  }
  std::vector<std::string> drawn(const std::string& picture, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> out = {"render", in("h.kiln"), "-o", in(picture), "--size", "24x24", "--samples", "1"};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
};

TEST_F(Names, ALinkStaysAndItsTargetIsWritten) {
  fs::create_directory(in("elsewhere"));
  fs::create_symlink("elsewhere/p.png", in("p.png"));
  fs::create_symlink("elsewhere/s.json", in("s.json"));
  fs::create_symlink("elsewhere/v.vdb", in("v.vdb"));
  done(drawn("p.png", {"--stats", in("s.json")}));
  done({"export", in("h.kiln"), in("v.vdb"), "--level", "1"});
  for (const char* name : {"p.png", "s.json", "v.vdb"}) {
    EXPECT_TRUE(fs::is_symlink(in(name))) << name;
    EXPECT_TRUE(fs::is_regular_file(fs::path(in("elsewhere")) / name)) << name;
  }
}

// A store behind a link is replaced like a store without a link, and its old contents are removed completely.
TEST_F(Names, AStoreBehindALinkIsReplaced) {
  fs::create_directory_symlink("h.kiln/", in("link.kiln"));
  done({"convert", "phantom:head:32x32x32", in("link.kiln"), "--brick-size", "16", "--overwrite"});
  EXPECT_TRUE(fs::is_symlink(in("link.kiln")));
  EXPECT_EQ(done({"info", in("h.kiln"), "--json"}).out, done({"info", in("link.kiln"), "--json"}).out);
  done({"verify", in("h.kiln")});
}

// As in `kiln ... --stats /dev/stdout > log`: behind earlier output, and without the command's text.
TEST_F(Names, StandardOutputHoldsTheFileAlone) {
  fs::create_symlink("/dev/stdout", in("out.png"));
  const std::string log = in("log"), kiln = "'" + std::string(KILN_TOOL) + "'", store = "'" + in("h.kiln") + "'";
  const auto written = [&](const std::string& arguments, const char* into) {
    const std::string command =
        "{ echo begun; " + kiln + " " + arguments + " 2> '" + in("err") + "'; } " + into + " '" + log + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << readTextFile(in("err"));
    const std::string text = readTextFile(log);
    EXPECT_TRUE(text.starts_with("begun\n")) << text;
    return text.substr(6);
  };
  const std::string drawn = "render " + store + " --size 24x24 --samples 1 -o '";
  for (const char* const into : {">", "| cat >"}) {
    EXPECT_EQ(Json::parse(written(drawn + in("p.png") + "' --stats /dev/stdout", into))["frames"].size(), 1u);
    EXPECT_NE(readTextFile(in("err")).find(in("p.png") + ": 24 x 24 pixels"), std::string::npos);
    EXPECT_EQ(written(drawn + in("out.png") + "'", into), readTextFile(in("p.png")));
    EXPECT_NE(readTextFile(in("err")).find(in("out.png") + ": 24 x 24 pixels"), std::string::npos);
    written("slice " + store + " -o '" + in("out.png") + "'", into);
    EXPECT_FALSE(readTextFile(in("err")).empty());
  }
}

TEST_F(Names, NoTwoFilesHaveOne) {
  writeText(in("trace.json"), R"({"kiln": 1, "volume": "h.kiln", "output": "x.png", "trace": "x.png"})");
  refused({"render", in("trace.json")}, 2, "x.png is the name of another file");
  refused(drawn("f_##.png", {"--turntable", "2", "--stats", in("f_01.png")}), 2, "f_01.png is the name");
  const std::string first = R"({"path": "n_#.png"})", second = R"({"path": ")" + in("n_##.png") + R"("})";
  writeText(in("two.json"),
            R"({"kiln": 1, "volume": "h.kiln", "frames": "9-10", "outputs": [)" + first + ", " + second + R"(]})");
  refused({"render", in("two.json")}, 2, "n_10.png: is named twice");
  // A link to an output counts as the output's name.
  fs::create_symlink("p.png", in("link.png"));
  refused(drawn("p.png", {"--stats", in("link.png")}), 2, "link.png is the name of another file");
  fs::create_symlink("trace.json", in("t.json"));
  refused({"render", in("trace.json"), "-o", in("p.png"), "--trace", in("t.json")}, 2, "t.json is the name");
}

TEST_F(Names, ThatCannotBeMadeAreRefusedBeforeTheWork) {
  refused(drawn(std::string(245, 'a') + ".png"), 1, "its name is 7 bytes too long");
  fs::create_directory(in("folder"));
  refused(drawn("p.png", {"--trace", in("folder")}), 1, "is a directory; name a file");
  refused(drawn("p.png", {"--stats", in("none/s.json"), "--repeat", "2"}), 1, "there is no directory");
  refused(drawn("p.png", {"--stats", in("none/s.json"), "--dry-run"}), 1, "there is no directory");
  refused(drawn("p.png", {"--stats", "/dev/fd/99"}), 1, "/dev/fd/99");
  EXPECT_FALSE(fs::exists(in("p.png")));
}

// A pipe without a reader would block the command forever.
TEST_F(Names, OfPipesAreNoOutputs) {
  const std::string mention = ": is a named pipe; name a file";
  done(drawn("part.exr", {"--part", "1/1"}));
  for (const char* name : {"f.png", "f.exr", "f.json", "f.vdb", "f.mp4"})
    ASSERT_EQ(::mkfifo(in(name).c_str(), 0600), 0);
  refused(drawn("f.png", {}), 2, in("f.png") + mention);
  refused(drawn("f.exr", {}), 2, in("f.exr") + mention);
  refused(drawn("p.png", {"--stats", in("f.json")}), 2, in("f.json") + mention);
  refused(drawn("p.png", {"--stats", in("f.json"), "--dry-run"}), 2, in("f.json") + mention);
  refused(drawn("p.png", {"--trace", in("f.json")}), 2, in("f.json") + mention);
  if (std::system("ffmpeg -version > /dev/null 2>&1") == 0)
    refused(drawn("f.mp4", {"--turntable", "2"}), 2, in("f.mp4") + mention);
  refused({"slice", in("h.kiln"), "-o", in("f.png")}, 2, in("f.png") + mention);
  refused({"tf", "ct-bone", "-o", in("f.png")}, 2, in("f.png") + mention);
  refused({"compare", in("part.exr"), in("part.exr"), "-o", in("f.png")}, 2, in("f.png") + mention);
  refused({"composite", in("part.exr"), "-o", in("f.png")}, 2, in("f.png") + mention);
  refused({"export", in("h.kiln"), in("f.vdb"), "--overwrite"}, 2, in("f.vdb") + mention);
  EXPECT_TRUE(fs::is_fifo(in("f.vdb")));
  EXPECT_FALSE(fs::exists(in("p.png")));
  // Devices are valid outputs: /dev/null accepts everything, /dev/full nothing.
  for (const char* name : {"null", "full"})
    for (const char* ending : {".png", ".json"})
      fs::create_symlink(std::string("/dev/") + name, in(std::string(name) + ending));
  done({"slice", in("h.kiln"), "-o", in("null.png")});
  done(drawn("p.png", {"--stats", in("null.json")}));
  done(drawn("p.png", {"--trace", in("null.json")}));
  refused({"slice", in("h.kiln"), "-o", in("full.png")}, 1, "No space left on device");
  refused(drawn("p.png", {"--trace", in("full.json")}), 1, "No space left on device");
}

TEST_F(Names, InATraceAreText) {
  done(drawn("a\"b\\gr\u00fcn\xff.png", {"--trace", in("t.json")}));
  const Json trace = Json::parse(readTextFile(in("t.json")));
  int found = 0;
  for (const Json& event : trace["traceEvents"]) {
    if (event.contains("args") && event["args"].contains("file"))
      found += event["args"]["file"] == "a\"b\\gr\u00fcn\\xff.png" ? 1 : 0;
  }
  EXPECT_EQ(found, 1);
}

TEST_F(Names, EndingsMayBeInCapitals) {
  writeText(in("J.JSON"),
            R"({"kiln": 1, "volume": "h.kiln", "output": "X.EXR", "image": {"width": 16, "height": 16}})");
  done({"render", in("J.JSON")});
  EXPECT_TRUE(fs::exists(in("X.EXR")));
  done(drawn("D.EXR", {"--deep"}));
  refused(drawn("V.MP4", {"--frames", "1-2", "--stereo", "both"}), 2, "--stereo");
}

// The pipe has no writer.
TEST_F(Names, APipeIsNoInput) {
  ASSERT_EQ(std::system(("mkfifo '" + in("v.nrrd") + "'").c_str()), 0);
  refused({"convert", in("v.nrrd"), in("v.kiln")}, 1, "is a pipe or a device");
}

TEST_F(Names, OptionsOfAForeignFileAreNotForAStore) {
  refused(drawn("p.png", {"--spacing", "1,1,5"}), 2, "--spacing applies to files without axes of their own only");
  refused(drawn("p.png", {"--dims", "3,3,3", "--type", "u8"}), 2, "--dims applies to headerless raw data only");
  refused(drawn("p.png", {"--channel", "2"}), 2, "--channel: a store has no channels; leave the option out");
  refused(drawn("p.png", {"--time", "2"}), 2, "--time: a store has no times; leave the option out");
  refused(drawn("p.png", {"--scale", "2"}), 2, "--scale: a store has no scales; leave the option out");
  refused(drawn("p.png", {"--luminance"}), 2, "--luminance applies to TIFF files of RGB colours only");
  // Options apply to INPUT, not to volumes added to the picture.
  writeRaw();
  writeText(in("v.nhdr"),
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 16\nspacings: 1 1 2\nencoding: raw\n"
            "data file: v.raw\n");
  done({"render", in("v.raw"), "-o", in("q.png"), "--dims", "16,16,16", "--type", "u8", "--spacing", "1,1,3", "--add",
        in("v.nhdr"), "--size", "24x24", "--samples", "1"});
  const auto depthOf = [&](const char* store) -> double {
    return Json::parse(done({"info", in(store), "--json"}).out)["affine"][10];
  };
  done({"render", in("v.raw"), "-o", in("q.png"), "--dims", "16,16,16", "--type", "u8", "--spacing", "1,1,3", "--add",
        in("h.kiln"), "--size", "24x24", "--samples", "1", "--dry-run"});
  EXPECT_EQ(depthOf("v.raw.kiln"), 3);
  EXPECT_EQ(depthOf("v.nhdr.kiln"), 2);
}

TEST_F(Names, ADryRunOfAForeignFileMakesNoStore) {
  writeRaw();
  std::vector<std::string> arguments = {"render",   in("v.raw"), "-o", in("q.png"), "--dims",
                                        "16,16,16", "--type",    "u8", "--size",    "24x24"};
  std::vector<std::string> dry = arguments;
  dry.push_back("--dry-run");
  refused(dry, 2, "is no store, and none of it is there");
  EXPECT_FALSE(fs::exists(in("v.raw.kiln")));
  done(arguments);
  EXPECT_NE(done(dry).out.find("bricks"), std::string::npos);
}

// Each part has the bricks of its box; with a brick missing, the part is damaged.
TEST_F(Names, PartsOfAStoreAreVerifiedAsSuch) {
  done({"split", in("h.kiln"), "-o", in("part_#.kiln"), "--parts", "4"});
  refused({"split", in("part_1.kiln"), "-o", in("of_part_#.kiln"), "--parts", "2"}, 2,
          in("part_1.kiln") + ": is a part that kiln split made");
  for (const char* name : {"part_1.kiln", "part_4.kiln"}) {
    const ToolResult verified = done({"verify", in(name)});
    EXPECT_NE(verified.out.find("has all of its part"), std::string::npos) << verified.out;
    EXPECT_EQ(verified.err.find("is no part of the store"), std::string::npos) << verified.err;
  }
  for (const auto& file : fs::directory_iterator(in("part_1.kiln/bricks/0"))) {
    fs::remove(file.path());
    break;
  }
  EXPECT_EQ(runTool({"verify", in("part_1.kiln")}).exit_code, 1);
  // A file named part.txt in a whole store does not belong to the store.
  writeText(in("h.kiln/part.txt"), "mine");
  EXPECT_NE(done({"verify", in("h.kiln")}).out.find("whole"), std::string::npos);
}

}  // namespace
}  // namespace kiln::test
