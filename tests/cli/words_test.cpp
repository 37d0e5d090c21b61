// Words of the command line for people: help by command, proposals for options of other programs, durations.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "support/system/run_tool.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

TEST(Words, HelpOfACommand_isThatOfItsOption) {
  const ToolResult help = runTool({"help", "slice"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.out, runTool({"slice", "--help"}).out);
  EXPECT_NE(help.out.find("--colormap"), std::string::npos);
  EXPECT_EQ(runTool({"help"}).out, runTool({"--help"}).out);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"help", "reder"}, {"reder", "--help"}}) {
    const ToolResult unknown = runTool(words);
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_EQ(unknown.err, "kiln: there is no command or option 'reder'; did you mean 'render'?\n");
    EXPECT_EQ(unknown.out, "");
  }
}

TEST(Words, UnknownOption_proposesAnOptionOfTheCommand) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"render", "a.kiln", "--bg", "white"}, "kiln: --bg: is no option of kiln render; --background?"},
      {{"render", "a.kiln", "--resolution=4x4"}, "kiln: --resolution: is no option of kiln render; --size?"},
      {{"render", "a.kiln", "--sampels", "4"}, "kiln: --sampels: is no option of kiln render; --samples?"},
      {{"render", "a.kiln", "--fps", "30"}, "kiln: --fps: is no option of kiln render; --rate?"},
      {{"slice", "a.kiln", "-o", "a.png", "--color", "fire"}, "kiln: --color: is no option of kiln slice; --colormap?"},
      {{"verify", "a.kiln", "--quux"}, "kiln: --quux: is no option of kiln verify; run 'kiln verify --help'"}};
  for (const auto& [arguments, expected] : cases) {
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, expected + "\n");
  }
}

TEST(Words, UnknownCommand_proposesACommand) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"reder", "kiln: there is no command or option 'reder'; did you mean 'render'?\n"},
      {"conv", "kiln: there is no command or option 'conv'; did you mean 'convert'?\n"},
      {"quux", "kiln: there is no command or option 'quux'; run 'kiln --help'\n"}};
  for (const auto& [word, expected] : cases) {
    const ToolResult result = runTool({word, "a.kiln"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, expected);
  }
}

TEST(Words, UnknownWordOfAnOption_proposesAWord) {
  const ToolResult result = runTool({"render", "phantom:head:8x8x8", "-o", "a.png", "--look", "studoi"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err, "kiln: --look: expected one of plain, studio, found 'studoi'; did you mean 'studio'?\n");
}

TEST(Words, OptionGivenTwice_isNamedWithItsValues) {
  const ToolResult result = runTool({"render", "a.kiln", "-o", "a.png", "--look", "plain", "--look", "studio"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err, "kiln: --look: takes one value (found plain and studio); give the option once\n");
}

TEST(Words, SurplusWord_leadsToItsOption) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"convert", "a.nrrd", "b.nrrd", "out.kiln"},
       "convert: expected INPUT and OUT (found a.nrrd b.nrrd out.kiln); convert one volume at a time, and name slices "
       "by "
       "their folder"},
      {{"export", "a.kiln", "a.nrrd", "b.nrrd"},
       "export: expected STORE and OUT (found a.kiln a.nrrd b.nrrd); run kiln export for one after the other"},
      {{"slice", "a.kiln", "a b.png"},
       "slice: expected STORE (found a.kiln 'a b.png'); -o 'a b.png' names the file to write"},
      {{"split", "a.kiln", "b.kiln", "-o", "p_#.exr"},
       "split: expected STORE (found a.kiln b.kiln); run kiln split for one after the other"},
      {{"render", "a.kiln", "b.png"}, "render: expected INPUT (found a.kiln b.png); -o b.png names the file to write"},
      {{"render", "a.kiln", "b.kiln"},
       "render: expected INPUT (found a.kiln b.kiln); --add b.kiln shows a further volume"},
      {{"gallery", "a.kiln", "b.kiln"},
       "gallery: expected STORE (found a.kiln b.kiln); run kiln gallery for one after the other"},
      {{"schema", "a"}, "schema: expected options only (found a); leave the words out"},
      {{"verify", "a.kiln", "b.kiln"},
       "verify: expected STORE (found a.kiln b.kiln); run kiln verify for one after the other"},
      {{"compare", "a.png", "b.png", "c.png", "-o", "d.png"},
       "compare: expected A and B (found a.png b.png c.png); run kiln compare for one after the other"}};
  for (const auto& [arguments, expected] : cases) {
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, "kiln: " + expected + "\n");
  }
}

TEST(Words, EndingsOfOutputs_areListed) {
  const std::filesystem::path directory = freshDirectory("words_endings");
  const std::string store = (directory / "h.kiln").string();
  ASSERT_EQ(runTool({"convert", "phantom:head:24x24x24", store}).exit_code, 0);
  for (const char* name : {"x.gif", "x.webp", "x"}) {
    const ToolResult result = runTool({"render", store, "-o", (directory / name).string()});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("pictures end in .exr, .png, .tif or .jpg, videos in .mp4, .mov, .mkv or .webm"),
              std::string::npos)
        << result.err;
  }
  const ToolResult video = runTool({"render", store, "-o", (directory / "x.mp4").string()});
  EXPECT_EQ(video.exit_code, 2);
  EXPECT_NE(video.err.find("x.mp4: a video needs frames (found 1); add --turntable"), std::string::npos) << video.err;
}

// Shares of N machines are the whole together.
TEST(Words, SharesOfFrames_areEachFrameOnce) {
  const std::filesystem::path directory = freshDirectory("words_share");
  const std::string store = (directory / "h.kiln").string();
  ASSERT_EQ(runTool({"convert", "phantom:head:24x24x24", store}).exit_code, 0);
  const auto draw = [&](const std::string& share) {
    return runTool({"render", store, "-o", (directory / "f_#.png").string(), "--turntable", "9", "--frames", "2-6",
                    "--size", "8x8", "--share", share});
  };
  EXPECT_EQ(draw("2/3").exit_code, 0);
  const auto there = [&](int frame) {
    return std::filesystem::exists(directory / ("f_" + std::to_string(frame) + ".png"));
  };
  for (int frame = 1; frame <= 9; ++frame) EXPECT_EQ(there(frame), frame == 3 || frame == 6) << frame;
  EXPECT_EQ(draw("1/3").exit_code, 0);
  EXPECT_EQ(draw("3/3").exit_code, 0);
  for (int frame = 1; frame <= 9; ++frame) EXPECT_EQ(there(frame), frame >= 2 && frame <= 6) << frame;
  for (const char* wrong : {"0/3", "4/3", "1", "a/b", "6/6"}) {
    const ToolResult result = draw(wrong);
    EXPECT_EQ(result.exit_code, 2) << wrong;
    EXPECT_EQ(result.err.find("kiln: --share"), 0u) << result.err;
  }
}

TEST(Words, FolderForATransferFunction_isNamed) {
  const std::filesystem::path directory = freshDirectory("words_folder");
  const std::string store = (directory / "h.kiln").string();
  ASSERT_EQ(runTool({"convert", "phantom:head:24x24x24", store}).exit_code, 0);
  const ToolResult result =
      runTool({"render", store, "-o", (directory / "p.png").string(), "--tf", directory.string()});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err.find("kiln: --tf: '" + directory.string() + "' is a folder; name a file"), 0u) << result.err;
}

// A phantom's header is known; a NRRD file of the test's own has what its lines have.
TEST(Words, InfoOfAVolumeFile_isItsHeader) {
  const std::filesystem::path directory = freshDirectory("words_info");
  writeText(
      directory / "a.nrrd",
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 4\nspacings: 1 1 2\nencoding: raw\n\n" + std::string(24, 'x'));
  const ToolResult file = runTool({"info", (directory / "a.nrrd").string()});
  EXPECT_EQ(file.exit_code, 0) << file.err;
  for (const char* line : {"(NRRD)\n", "2 x 3 x 4 voxels of u8 (24 bytes)", "spacing      1 x 1 x 2 world units"})
    EXPECT_NE(file.out.find(line), std::string::npos) << line << " is not in: " << file.out;
  const ToolResult json = runTool({"info", (directory / "a.nrrd").string(), "--json"});
  for (const char* key : {"\"rawBytes\": 24", "\"frame\": \"unknown\"", "\"class\": \"unknown\"", "\"type\": \"u8\""})
    EXPECT_NE(json.out.find(key), std::string::npos) << key << " is not in: " << json.out;
  EXPECT_NE(runTool({"info", "phantom:head:64x64x64"}).out.find("64 x 64 x 64 voxels of u16"), std::string::npos);
  writeText(directory / "b.raw", std::string(24, 'x'));
  const ToolResult raw = runTool({"info", (directory / "b.raw").string(), "--dims", "2,3,4", "--type", "u8"});
  EXPECT_NE(raw.out.find("2 x 3 x 4 voxels of u8"), std::string::npos) << raw.out << raw.err;
  // The folder of an unfinished conversion is no folder of slices.
  std::filesystem::create_directory(directory / "part.kiln");
  writeText(directory / "part.kiln/journal.bin", "");
  const ToolResult part = runTool({"info", (directory / "part.kiln").string()});
  EXPECT_EQ(part.exit_code, 1);
  EXPECT_NE(part.err.find("manifest.json: is missing"), std::string::npos) << part.err;
}

// A conversion without notes is silent; what a dry run shows is no report.
TEST(Words, QuietConversions_printNothing) {
  const std::filesystem::path directory = freshDirectory("words_quiet");
  const std::string store = (directory / "h.kiln").string(), file = (directory / "h.nrrd").string();
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"convert", "phantom:head:24x24x24", store}, {"export", store, file}}) {
    std::vector<std::string> quiet = command;
    quiet.emplace_back("--quiet");
    const ToolResult result = runTool(quiet);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out + result.err, "");
    EXPECT_TRUE(std::filesystem::exists(command.back()));
  }
  EXPECT_NE(runTool({"convert", "phantom:head:24x24x24", "--dry-run", "--quiet"}).out, "");
}

// The user's bounds, bytes read and memory, stand in every report but the quiet one.
TEST(Words, ALineForAFrame_isShortUnlessAskedFor) {
  const std::filesystem::path directory = freshDirectory("words_lines");
  const std::string store = (directory / "h.kiln").string(), picture = (directory / "p.png").string();
  ASSERT_EQ(runTool({"convert", "phantom:head:24x24x24", store}).exit_code, 0);
  const std::vector<std::string> draw = {"render", store, "-o", picture, "--size", "32x32", "--samples", "1"};
  const auto printed = [&](const char* option) {
    std::vector<std::string> arguments = draw;
    if (option != nullptr) arguments.emplace_back(option);
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return result.out;
  };
  const std::regex brief(".*p\\.png: 32 x 32 pixels, [0-9.]+ s, [0-9.]+ [KM]iB read, peak [0-9.]+ MiB\n");
  EXPECT_TRUE(std::regex_match(printed(nullptr), brief)) << printed(nullptr);
  EXPECT_EQ(printed("--quiet"), "");
  const std::string verbose = printed("--verbose");
  EXPECT_NE(verbose.find("1 of 1 bricks read"), std::string::npos) << verbose;
  EXPECT_NE(verbose.find("voxels visited"), std::string::npos) << verbose;
}

}  // namespace
}  // namespace kiln::test
