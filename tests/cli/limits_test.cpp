// Numbers that are too large and limits of the system end in one line and an exit code, never in an abort.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <regex>
#include <set>

#include "base/file/file.h"
#include "support/files/foreign_files.h"
#include "support/files/tiff_files.h"
#include "support/system/sanitized.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class Limits : public ToolTest {
 protected:
  Limits() : ToolTest("limits_") {}
  void SetUp() override { done({"convert", "phantom:head:32x32x32", in("h.kiln"), "--brick-size", "8"}); }

  std::set<std::string> names() const {
    std::set<std::string> out;
    for (const auto& entry : fs::directory_iterator(directory_)) out.insert(entry.path().filename().string());
    return out;
  }
  // Returns a job with `count` copies of an entry in the list `list`.
  std::string job(const std::string& list, const std::string& entry, std::size_t count) const {
    return jobWith("\"" + list + "\": " + listOf(entry, count));
  }
  static std::string listOf(const std::string& entry, std::size_t count) {
    std::string out = "[";
    for (std::size_t i = 0; i < count; ++i) out += (i > 0 ? ", " : "") + entry;
    return out + "]";
  }
  std::string jobWith(const std::string& more) const {
    writeText(in("many.json"), R"({"kiln": 1, "volume": "h.kiln", "output": "o.png", )" + more + "}");
    return in("many.json");
  }
};

TEST_F(Limits, TooManyOfAThing_isRefusedInOneLine) {
  refused({"render", in("h.kiln"), "-o", in("o_#.png"), "--turntable", "2147483647"}, 2,
          "--turntable: expected a whole number of frames from 1 to 1000000, found '2147483647'");
  refused({"render", job("clip", R"({"normal": [1, 0, 0], "offset": 5})", 65)}, 2,
          "expected at most 64 planes, found 65");
  refused({"render", job("lights", R"({"type": "headlight"})", 65)}, 2, "expected at most 64 lights, found 65");
  std::vector<std::string> many = {"render", in("h.kiln"), "-o", in("o.png")};
  for (int i = 0; i < 65; ++i) many.insert(many.end(), {"--clip", "1,0,0,5"});
  refused(many, 2, "--clip: expected at most 64 planes, found 65");
  for (const char* command : {"render", "convert", "verify"}) {
    std::vector<std::string> arguments = {command, in("h.kiln"), "--threads", "200000"};
    if (command != std::string("verify")) arguments.insert(arguments.end() - 2, {"-o", in("o.png")});
    if (command == std::string("convert")) arguments = {command, in("h.raw"), in("c.kiln"), "--threads", "200000"};
    refused(arguments, 2, "expected a whole number from 0 to 4096, found '200000'");
  }
  writeText(in("nested.json"), std::string(200000, '[') + std::string(200000, ']'));
  refused({"render", in("nested.json")}, 1, "nested more than 100 deep");
}

TEST_F(Limits, ListsOfAJobThatAreTooLong_areRefusedInOneLine) {
  const auto keys = [](const std::string& owner) {
    return "\"" + owner + R"(": {"keyframes": )" + listOf("{}", 10001) + "}";
  };
  for (const char* owner : {"camera", "transferFunction", "lights", "clip"})
    refused({"render", jobWith(keys(owner))}, 2,
            owner + std::string(".keyframes: expected at most 10000 keys, found 10001"));
  refused({"render", jobWith(R"("stereo": {"eye": "both", "keyframes": )" + listOf("{}", 10001) + "}")}, 2,
          "stereo.keyframes: expected at most 10000 keys, found 10001");
  refused({"render", jobWith(R"("camera": {"matrices": )" + listOf("0", 100001) + "}")}, 2,
          "expected at most 100000 matrices, found 100001");
  refused({"render", job("outputs", "{}", 65)}, 2, "expected at most 64 files, found 65");
  writeText(in("volumes.json"), R"({"kiln": 1, "output": "o.png", "volumes": )" + listOf("{}", 65) + "}");
  refused({"render", in("volumes.json")}, 2, "expected at most 64 volumes, found 65");
  const auto function = [&](const std::string& key, std::size_t count) {
    return jobWith(R"("transferFunction": {)" + ("\"" + key) + "\": " + listOf("{}", count) + "}");
  };
  refused({"render", function("points", 65537)}, 2, "expected at most 65536 points, found 65537");
  refused({"render", function("labels", 65537)}, 2, "expected at most 65536 labels, found 65537");
  const std::string point = R"({"value": 0, "color": [0, 0, 0], "opacity": 0})";
  refused({"render", jobWith(R"("transferFunction": {"points": [)" + point + R"(], "gradientOpacity": )" +
                             listOf("{}", 65537) + "}")},
          2, "expected at most 65536 points, found 65537");
}

// Labels are lines of text, so no bound of a JSON list applies.
TEST_F(Limits, ALabelBeyondTheMostOfAFunction_isRefusedWithItsLine) {
  std::string text;
  for (int i = 1; i <= 65537; ++i) text += std::to_string(i) + " 0 0 0 1 1 1 \"\"\n";
  writeText(in("labels.txt"), text);
  refused({"render", in("h.kiln"), "-o", in("o.png"), "--tf", in("labels.txt")}, 1,
          "line 65537: a transfer function has at most 65536 labels; describe those to draw");
}

TEST_F(Limits, NumbersThatAreNone_areRefusedInOneLine) {
  for (const char* none : {"nan", "-nan", "inf", "-inf", "1e400", "one"}) {
    for (const char* option : {"--rank-timeout", "--fov", "--azimuth", "--elevation", "--zoom", "--convergence",
                               "--interocular", "--opacity-threshold", "--sample-distance", "--deep-error", "--ambient",
                               "--diffuse", "--specular", "--power"}) {
      const ToolResult result = runTool({"render", in("h.kiln"), "-o", in("o.exr"), "--size", "16x16", "--stereo",
                                         "left", "--deep", std::string(option) + "=" + none});
      EXPECT_EQ(result.exit_code, 2) << option << " " << none << ": " << result.err;
      EXPECT_EQ(result.errorLines().size(), 1u) << option << " " << none << ": " << result.err;
    }
  }
  refused({"convert", in("h.raw"), in("c.kiln"), "--rank-timeout", "nan"}, 2,
          "expected a number from 0 to 1000000, found 'nan'");
}

TEST_F(Limits, AddressSpaceThatIsTooSmall_endsInOneLine) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer reserves terabytes of addresses";
  int failed = 0;
  for (const std::uint64_t megabytes : {80, 100, 140}) {
    ToolOptions options;
    options.address_bytes = megabytes << 20;
    const ToolResult result = runTool({"render", in("h.kiln"), "-o", in("o.png"), "--size", "3000x3000"}, options);
    if (result.exit_code == 0) continue;
    // Below some size the system's loader has no room for the libraries: exit code 127, with the loader's own line.
    EXPECT_TRUE(result.exit_code == 1 || result.exit_code == 127) << megabytes << ": " << result.err;
    EXPECT_EQ(result.errorLines().size(), 1u) << megabytes << ": " << result.err;
    failed += result.exit_code == 1 ? 1 : 0;
  }
  EXPECT_GT(failed, 0);
}

// Known because an option that refuses letters while the command line is parsed takes no text.
TEST_F(Limits, EveryOptionThatIsANumber_takesDecimalDigitsOnly) {
  const std::array<std::string, 4> kNone = {"nan", "0x10", " 5", "5x"};
  const std::regex option("\n +(?:-\\w,)?(--[\\w-]+) ");
  int numbers = 0;
  for (const std::string command : {"convert", "info", "verify", "export", "slice", "tf", "render", "split",
                                    "composite", "compare", "bench", "manual", "schema"}) {
    const std::string help = done({command, "--help"}).out;
    for (std::sregex_iterator at(help.begin(), help.end(), option), end; at != end; ++at) {
      const std::string name = (*at)[1];
      const auto refusal = [&](const std::string& text) {
        const ToolResult result = runTool({command, name + "=" + text});
        return result.exit_code == 2 && result.errorLines().size() == 1 &&
               result.err.find(name + ": ") != std::string::npos;
      };
      if (name == "--help" || !refusal("letters")) continue;
      // Each option gets one of the texts in turn, since a run takes some hundredths of a second.
      const std::string none = kNone[static_cast<std::size_t>(++numbers) % kNone.size()];
      EXPECT_TRUE(refusal(none)) << command << " " << name << "='" << none << "'";
      // A whole number with a leading 0 would be octal.
      if (refusal("1.5")) {
        EXPECT_TRUE(refusal("010")) << command << " " << name;
      }
    }
  }
  EXPECT_GT(numbers, 30) << "the walk over the options has lost its point";
}

// Known because a stack of slices has more files than a process may open, and each command leaves all files as they
// were.
TEST_F(Limits, FewOpenFiles_leaveNothingBehind) {
  fs::create_directories(in("slices"));
  const ForeignVolume slices = randomVolume({8, 8, 120}, VoxelType::u8, 1);
  for (int z = 0; z < 120; ++z) writeTiff(in("slices/s" + std::to_string(z) + ".tif"), slices, z, z + 1);
  const std::set<std::string> before = names();
  for (const std::uint64_t files : {6, 15, 16, 24, 40}) {
    ToolOptions options;
    options.open_files = files;
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"convert", in("slices"), in("c.kiln"), "--brick-size", "16", "--threads", "2"},
             {"convert", "phantom:head:32x32x32", in("h.kiln"), "--brick-size", "8", "--overwrite", "--threads", "2"},
             {"render", in("h.kiln"), "-o", in("o_#.png"), "--size", "24x24", "--turntable", "2", "--threads", "2"},
             {"render", in("h.kiln"), "-o", in("o.exr"), "--size", "24x24", "--trace", in("t.json"), "--threads", "2"},
             {"split", in("h.kiln"), "-o", in("part_#.kiln"), "--parts", "2"},
             {"export", in("h.kiln"), in("o.vdb")},
             {"verify", in("h.kiln")}}) {
      const ToolResult result = runTool(arguments, options);
      if (files < 16) {
        EXPECT_EQ(result.exit_code, 1) << files << ": " << arguments[0];
        EXPECT_EQ(result.err, "kiln: this process may have " + std::to_string(files) +
                                  " files open, and at least 16 are needed; allow more (ulimit -n 1024 is enough)\n");
        EXPECT_EQ(names(), before) << files << ": " << arguments[0];
      } else {
        EXPECT_EQ(result.exit_code, 0) << files << ": " << arguments[0] << ": " << result.err;
      }
      for (const std::string& name : names()) {
        if (before.contains(name)) continue;
        EXPECT_EQ(name.find(".partial"), std::string::npos) << name;
        EXPECT_EQ(name.find(".old"), std::string::npos) << name;
        EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
      }
      for (const std::string& name : names())
        if (!before.contains(name)) fs::remove_all(in(name));
    }
  }
}

}  // namespace
}  // namespace kiln::test
