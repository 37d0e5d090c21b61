// The program as its users see it: files, output, and the exit code: 0 done, 1 data or I/O, 2 command line. A failure
// is exactly one line on stderr that names the file or the option.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "base/file/file.h"
#include "base/memory/memory.h"
#include "convert/resume/journal.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "store/store_reader.h"
#include "support/files/foreign_files.h"
#include "support/files/vdb_files.h"
#include "support/system/run_tool.h"
#include "support/system/text_of.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

std::uint64_t sumOf(const Json& object, const std::vector<std::string>& keys) {
  std::uint64_t sum = 0;
  for (const std::string& key : keys) sum += object[key].get<std::uint64_t>();
  return sum;
}

class Cli : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = freshDirectory(std::string("cli_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
  }

  std::string in(const std::string& name) const { return (directory_ / name).string(); }

  // v.raw: 24 x 20 x 16 bytes; voxel (i,j,k) is 10 i + 1.
  void writeRamp() const { writeText(in("v.raw"), textOf(ramp({{24, 20, 16}, VoxelType::u8}, 1, 10).voxels)); }
  std::vector<std::string> rampArguments() const { return {"--dims", "24,20,16", "--type", "u8"}; }

  // v.kiln, of v.raw.
  void makeRampStore(const std::string& brick_size = "16") const {
    writeRamp();
    expectDone(
        {"convert", in("v.raw"), in("v.kiln"), "--dims", "24,20,16", "--type", "u8", "--brick-size", brick_size});
  }

  ToolResult expectDone(const std::vector<std::string>& arguments) const {
    const ToolResult result = runTool(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_FALSE(result.timed_out);
    return result;
  }

  // Runs a command that must fail. Tests the exit code, and that stderr is a single line containing all of `mentions`.
  ToolResult expectRefused(const std::vector<std::string>& arguments, int exit_code,
                           const std::vector<std::string>& mentions, const ToolOptions& options = {}) const {
    std::string command;
    for (const std::string& argument : arguments) command += " " + argument;
    SCOPED_TRACE("kiln" + command);
    const ToolResult result = runTool(arguments, options);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    const std::vector<std::string> lines = result.errorLines();
    EXPECT_EQ(lines.size(), 1u) << result.err;
    EXPECT_TRUE(result.err.starts_with("kiln: ")) << result.err;
    EXPECT_EQ(result.err.find("defect"), std::string::npos) << result.err;
    EXPECT_EQ(result.out, "");
    for (const std::string& mention : mentions)
      EXPECT_NE(result.err.find(mention), std::string::npos) << "'" << mention << "' is not in: " << result.err;
    return result;
  }

  std::vector<std::string> listing() const {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(directory_)) out.push_back(entry.path().filename().string());
    std::sort(out.begin(), out.end());
    return out;
  }

  fs::path directory_;
};

// --- Commands that succeed ---

// Known because the volume is a ramp: its numbers follow from the formula.
TEST_F(Cli, ConvertInfoVerify) {
  makeRampStore();
  const ToolResult info = expectDone({"info", in("v.kiln")});
  for (const char* says : {"24 x 20 x 16", "u8", "1 to 231", "4 bricks of 16^3: 4 stored in ", " 0 constant", "v.raw",
                           "% of the 7.50 KiB of its voxels", "histogram"})
    EXPECT_NE(info.out.find(says), std::string::npos) << info.out;
  // Each of 24 values occurs in equally many voxels, and a row prints the number of voxels.
  std::uint64_t counted = 0;
  std::istringstream lines(info.out);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" %  ") != std::string::npos) counted += std::stoull(line.substr(line.find(" %  ") + 4));
  }
  EXPECT_EQ(counted, 24u * 20 * 16) << info.out;
  const ToolResult json = expectDone({"info", in("v.kiln"), "--json"});
  Json printed = Json::parse(json.out);
  EXPECT_EQ(printed["range"], Json::array({1.0, 231.0}));
  std::uint64_t disk_bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(in("v.kiln")))
    disk_bytes += entry.is_regular_file() ? entry.file_size() : 0;
  EXPECT_EQ(printed["storage"]["rawBytes"], 24 * 20 * 16);
  EXPECT_EQ(printed["storage"]["diskBytes"], disk_bytes);
  EXPECT_EQ(printed["storage"]["constantBricks"], Json::array({0, 0}));
  printed.erase("storage");
  EXPECT_EQ(printed, Json::parse(readTextFile(in("v.kiln") + "/manifest.json")));
  const ToolResult verify = expectDone({"verify", in("v.kiln")});
  EXPECT_NE(verify.out.find("whole, 7 files"), std::string::npos) << verify.out;
  EXPECT_EQ(info.err + json.err + verify.err, "");
  expectDone({"convert", in("v.raw"), in("v.kiln"), "--dims", "24,20,16", "--type", "u8", "--overwrite", "--brick-size",
              "128"});
  EXPECT_EQ(StoreReader(in("v.kiln")).manifest().brick_size, 128);
  EXPECT_EQ(listing(), (std::vector<std::string>{"v.kiln", "v.raw"}));
}

// Known because the job stored in a picture reproduces the picture's bytes.
TEST_F(Cli, InfoOfAPictureIsTheJobThatDrawsIt) {
  makeRampStore();
  for (const char* ending : {"exr", "png"}) {
    const std::string picture = in(std::string("p.") + ending), again = in(std::string("again.") + ending);
    expectDone({"render", in("v.kiln"), "-o", picture, "--size", "40x30", "--tf", "iso:120", "--view", "left",
                "--comments", "two\nlines"});
    const ToolResult info = expectDone({"info", picture});
    for (const char* says : {"picture      ", "comments     \ntwo\nlines\n", "kiln:version ", "\"transferFunction\""})
      EXPECT_NE(info.out.find(says), std::string::npos) << info.out;
    FileSystem::real().writeAtomic(in("job.json"), expectDone({"info", picture, "--json"}).out);
    expectDone({"render", in("job.json"), "-o", again, "--comments", "two\nlines"});
    EXPECT_EQ(readFile(again), readFile(picture)) << ending;
  }
  // The file type of the first picture is kept, although the job names no files.
  for (const std::vector<std::string>& stored :
       {std::vector<std::string>{"p.exr", "--exr-type", "float", "--compression", "piz", "--aov", "depth"},
        std::vector<std::string>{"p.png", "--png-bits", "16"}}) {
    const std::string picture = in(stored[0]), again = in("again_" + stored[0]);
    std::vector<std::string> first = {"render", in("v.kiln"), "-o", picture, "--size", "40x30", "--crop", "3,2,20,10"};
    first.insert(first.end(), stored.begin() + 1, stored.end());
    expectDone(first);
    FileSystem::real().writeAtomic(in("job.json"), expectDone({"info", picture, "--json"}).out);
    expectDone({"render", in("job.json"), "-o", again});
    EXPECT_EQ(readFile(again), readFile(picture)) << stored[0];
    expectDone({"render", picture, "-o", again});
    EXPECT_EQ(readFile(again), readFile(picture)) << stored[0];
    // The job also allows another file type.
    expectDone({"render", in("job.json"), "-o", in("other.exr")});
  }
  const std::string exr = expectDone({"info", in("p.exr")}).out;
  for (const char* says :
       {"pixels       20 x 10 from 3, 2, compression piz\n", "A float, B float, G float, R float", "Z float"})
    EXPECT_NE(exr.find(says), std::string::npos) << exr;
  EXPECT_NE(expectDone({"info", in("p.png")}).out.find("pixels       20 x 10 of 16 bits a channel\n"),
            std::string::npos);
  Image foreign(2, 2);
  writeImage(foreign, {}, {}, in("f.png"));
  EXPECT_EQ(expectDone({"info", in("f.png")}).out,
            "picture      " + in("f.png") + "\npixels       2 x 2 of 8 bits a channel\n");
  expectRefused({"info", in("f.png"), "--json"}, 1, {in("f.png"), "kiln:job"});
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--unit", "mm"}, {"--store", in("stores")}})
    expectRefused({"info", in("f.png"), option[0], option[1]}, 2,
                  {in("f.png") + ": is a picture, and options of volume files"});
  expectRefused({"info", in("v.raw")}, 2, {in("v.raw"), "if it is headerless raw voxels, give --dims"});
  writeText(in("v.npz"), "PK\x03\x04");
  expectRefused({"info", in("v.npz")}, 1, {in("v.npz"), "a ZIP file, which is not read"});
}

// Known because the name contains the size, and the store's provenance is the requested name. A cache has no file to
// stand beside.
TEST_F(Cli, Phantom) {
  const ToolResult convert = expectDone({"convert", "phantom:head:24x20x16", in("h.kiln")});
  EXPECT_NE(convert.out.find("24 x 20 x 16 voxels of u16"), std::string::npos) << convert.out;
  EXPECT_EQ(Json::parse(expectDone({"info", in("h.kiln"), "--json"}).out)["source"]["files"],
            Json::array({"phantom:head:24x20x16"}));
  expectDone({"render", in("h.kiln"), "-o", in("h.png"), "--size", "20x20"});
  expectRefused({"convert", "phantom:cat:8x8x8", in("c.kiln")}, 2, {"phantom:cat:8x8x8", "body, head, brain, engine"});
  expectRefused({"convert", "phantom:head:8x8", in("c.kiln")}, 2, {"phantom:head:256x256x225"});
  expectRefused({"convert", "phantom:head:8x8x8", in("c.kiln"), "--dims", "8,8,8", "--type", "u8"}, 2, {"--dims"});
  expectRefused({"render", "phantom:head:8x8x8", "-o", in("r.png")}, 2, {"kiln convert phantom:head:8x8x8 NAME.kiln"});
  EXPECT_EQ(listing(), (std::vector<std::string>{"h.kiln", "h.png"}));
}

// Known because the window ends at the ramp's ends: black left, white right, and brighter from column to column.
TEST_F(Cli, Slice) {
  makeRampStore();
  expectDone({"slice", in("v.kiln"), "-o", in("s.png"), "--axis", "z", "--index", "3", "--window", "116,230"});
  const Image image = readImage(in("s.png"));
  ASSERT_EQ(image.width, 24);
  ASSERT_EQ(image.height, 20);
  EXPECT_NEAR(image.pixel(0, 7)[0], 0, 0.01);
  EXPECT_NEAR(image.pixel(23, 7)[0], 1, 0.01);
  for (int x = 1; x < 24; ++x) EXPECT_GT(image.pixel(x, 7)[1], image.pixel(x - 1, 7)[1]);
  // If a side is half a pixel longer than whole pixels, the last pixel shows the last voxel.
  expectDone({"convert", "phantom:head:8x8x3", in("odd.kiln"), "--spacing", "1,1,2.5"});
  expectDone({"slice", in("odd.kiln"), "-o", in("odd.png"), "--axis", "x"});
  const Image odd = readImage(in("odd.png"));
  ASSERT_EQ(odd.height, 8);
  for (int y = 0; y < odd.height; ++y) EXPECT_EQ(odd.pixel(4, y)[3], 1) << y;
  expectDone({"slice", in("v.kiln"), "-o", in("x.png"), "--axis", "x"});
  EXPECT_EQ(readImage(in("x.png")).width, 20);
  // A coarser level with voxels of twice the length, from the same black to the same white.
  expectDone({"convert", in("v.raw"), in("coarse.kiln"), "--dims", "24,20,16", "--type", "u8", "--brick-size", "8"});
  expectDone({"slice", in("coarse.kiln"), "-o", in("c.png"), "--level", "1", "--index", "1", "--window", "116,230"});
  const Image coarse = readImage(in("c.png"));
  ASSERT_EQ(coarse.width, 12);
  ASSERT_EQ(coarse.height, 10);
  for (int x = 0; x < 12; ++x)
    EXPECT_NEAR(coarse.pixel(x, 3)[1], (image.pixel(2 * x, 7)[1] + image.pixel(2 * x + 1, 7)[1]) / 2, 0.02);
  expectRefused({"slice", in("v.kiln"), "-o", in("m.png"), "--memory", "2K"}, 1, {in("v.kiln"), "--level"});
}

// Known because the command sets the picture's size, and the volume is in front of the camera.
TEST_F(Cli, RenderAndCompare) {
  makeRampStore();
  expectDone({"render", in("v.kiln"), "-o", in("a.png"), "--size", "40x30"});
  expectDone({"render", in("v.kiln"), "-o", in("a.exr"), "--size", "40x30", "--exr-type", "float"});
  expectDone({"render", in("v.kiln"), "-o", in("b.png"), "--size", "40x30", "--azimuth", "70"});
  for (const char* name : {"a.png", "a.exr", "b.png"}) {
    const Image image = readImage(in(name));
    EXPECT_EQ(image.width, 40);
    EXPECT_EQ(image.height, 30);
    EXPECT_GT(*std::max_element(image.rgba.begin(), image.rgba.end()), 0.05f) << name << " is empty";
  }
  EXPECT_NE(expectDone({"compare", in("a.png"), in("a.png")}).out.find("equal"), std::string::npos);
  const ToolResult compared = expectDone({"compare", in("a.png"), in("b.png"), "--json", "-o", in("d.png")});
  EXPECT_GT(Json::parse(compared.out)["differing_pixels"], 0);
  EXPECT_EQ(Json::parse(expectDone({"compare", in("a.png"), in("a.png"), "--json"}).out)["psnr_db"], "inf");
  Image broken = readImage(in("a.exr"));
  broken.rgba.front() = std::numeric_limits<float>::quiet_NaN();
  writeImage(broken, {}, {}, in("nan.exr"));
  const Json judged = Json::parse(expectDone({"compare", in("a.exr"), in("nan.exr"), "--json"}).out);
  EXPECT_EQ(judged["psnr_db"], "-inf");
  EXPECT_EQ(judged["largest"], "inf");
  EXPECT_EQ(readImage(in("d.png")).width, 40);
}

// Known because OpenVDB itself opens the exported grid; every voxel of the ramp differs from the background, 0.
TEST_F(Cli, Export) {
  makeRampStore();
  expectDone({"export", in("v.kiln"), in("v.vdb")});
  ASSERT_EQ(gridNames(in("v.vdb")), std::vector<std::string>{"density"});
  const auto active = DirectGrid(in("v.vdb"), "density").activeValues();
  EXPECT_EQ(active.size(), 24u * 20 * 16);
  for (const auto& [v, value] : active) EXPECT_EQ(value, 10.0 * static_cast<double>(v.x) + 1);
}

// Known because a path in a job is relative to the job, and an option overrides the path.
TEST_F(Cli, RenderOfAJob) {
  makeRampStore();
  writeText(in("job.json"),
            R"({"kiln": 1, "volume": "v.kiln", "output": "p.png", "image": {"width": 33, "height": 22}})");
  expectDone({"render", in("job.json")});
  EXPECT_EQ(readImage(in("p.png")).width, 33);
  expectDone({"render", in("job.json"), "--size", "12x11", "-o", in("q.png")});
  EXPECT_EQ(readImage(in("q.png")).height, 11);
}

// Known because a camera in fog sees fog: a picture, not an error.
TEST_F(Cli, TheEyeMayBeInsideTheVolume) {
  makeRampStore();
  expectDone({"render", in("v.kiln"), "-o", in("p.png"), "--size", "32x32", "--eye", "12,10,8", "--target", "20,10,8"});
  EXPECT_EQ(readImage(in("p.png")).width, 32);
}

// Known because 24 voxels in 8 pixels are a third of a pixel each, in 32 pixels more than a pixel; level 1 is a single
// brick.
TEST_F(Cli, LevelsOfDetailAreChosenOrForced) {
  makeRampStore();
  const auto drawn = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"render",     in("v.kiln"),   "-o",           in("p.png"), "--stats",
                                          in("s.json"), "--projection", "orthographic", "--samples", "1"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    expectDone(arguments);
    const Json stats = Json::parse(readTextFile(in("s.json")));
    EXPECT_EQ(stats["levels"].size(), 2u);
    EXPECT_EQ(stats["levels"][1]["level"], 1);
    EXPECT_EQ(stats["bricks"]["total"],
              stats["levels"][0]["bricks"].get<int>() + stats["levels"][1]["bricks"].get<int>());
    return std::pair(stats["levels"][0]["bricks"].get<int>(), stats["levels"][1]["bricks"].get<int>());
  };
  EXPECT_EQ(drawn({"--size", "32x32"}), std::pair(4, 0));
  EXPECT_EQ(drawn({"--size", "8x8"}), std::pair(0, 1));
  EXPECT_EQ(drawn({"--size", "8x8", "--level", "auto"}), std::pair(0, 1));
  EXPECT_EQ(drawn({"--size", "8x8", "--level", "0"}), std::pair(4, 0));
  EXPECT_EQ(drawn({"--size", "32x32", "--level", "1"}), std::pair(0, 1));
}

// Known: scripts outside the project read these keys.
TEST_F(Cli, StatisticsHaveTheKeysOfTheContract) {
  makeRampStore();
  expectDone({"render", in("v.kiln"), "-o", in("p.png"), "--size", "32x32", "--stats", in("s.json"), "--repeat", "3"});
  const Json stats = Json::parse(readTextFile(in("s.json")));
  ASSERT_EQ(stats["frames"].size(), 3u);
  for (const Json& frame : stats["frames"]) EXPECT_GT(frame["wall_s"], 0.0);
  for (const char* key :
       {"/voxels/visited", "/voxels/splats", "/nodes/tested", "/nodes/hidden", "/bricks/total", "/bricks/interesting",
        "/bricks/read", "/bricks/hidden", "/bricks/read_bytes", "/memory/budget_bytes", "/memory/peak_cache_bytes",
        "/memory/peak_rss_bytes", "/time/load_s", "/time/render_s", "/time/output_s"}) {
    const Json::json_pointer at(key);
    EXPECT_TRUE(stats.contains(at) && stats.at(at).is_number()) << key;
  }
  EXPECT_EQ(stats["bricks"]["total"], 4);
  EXPECT_EQ(stats["memory"]["budget_bytes"], 2ull << 30);
  EXPECT_EQ(
      stats["memory"]["budget_bytes"],
      sumOf(stats["memory"], {"cache_bytes", "framebuffer_bytes", "visibility_bytes", "index_bytes", "slabs_bytes",
                              "shadows_bytes", "functions_bytes", "trace_bytes", "files_bytes", "threads_bytes"}));
  EXPECT_LE(stats["memory"]["peak_cache_bytes"], stats["memory"]["cache_bytes"]);
}

// Known from the memory account of a frame: no buffer is larger than its reservation.
TEST_F(Cli, WhatLatticesDrawWithIsInTheAccount) {
  makeRampStore();
  for (const char* lattice : {"pixel", "voxel"}) {
    // As a single tile, and in tiles that bricks overlap by parts of different sizes.
    for (const char* tile : {"0", "64"}) {
      SCOPED_TRACE(fmt::format("{} in tiles of {}", lattice, tile));
      expectDone({"render", in("v.kiln"), "-o", in("p.png"), "--size", "200x150", "--lattice", lattice, "--tile", tile,
                  "--stats", in("s.json")});
      const Json memory = Json::parse(readTextFile(in("s.json")))["memory"];
      EXPECT_LE(memory["peak_slabs_bytes"], memory["slabs_bytes"]);
      // The pixel lattice keeps no buffers between tiles.
      EXPECT_EQ(memory["peak_slabs_bytes"] > 0, std::string(lattice) == "voxel");
    }
  }
}

// Known from the rule that performance options change no bit of a picture.
TEST_F(Cli, ThreadsAndMemoryDoNotChangeThePicture) {
  const DenseVolume volume = cheese({{60, 50, 70}, VoxelType::u16, anisotropicAffine()}, 3, usualRange(VoxelType::u16));
  writeText(in("c.raw"), textOf(volume.voxels));
  expectDone({"convert", in("c.raw"), in("c.kiln"), "--dims", "60,50,70", "--type", "u16", "--brick-size", "16",
              "--threads", "2"});
  std::vector<std::byte> first;
  for (const char* threads : {"1", "2"}) {
    for (const char* memory : {"32M", "2G"}) {
      expectDone(
          {"render", in("c.kiln"), "-o", in("p.png"), "--size", "90x70", "--threads", threads, "--memory", memory});
      const std::vector<std::byte> picture = readFile(in("p.png"));
      if (first.empty()) first = picture;
      EXPECT_TRUE(picture == first) << threads << " threads, " << memory;
    }
  }
}

// Known because a frame that hides nothing reads all bricks in view. The smallest memory printed works, and a megabyte
// less does not.
TEST_F(Cli, ADryRunForetellsTheRender) {
  const DenseVolume volume = cheese({{60, 50, 70}, VoxelType::u16, anisotropicAffine()}, 3, usualRange(VoxelType::u16));
  writeText(in("c.raw"), textOf(volume.voxels));
  expectDone({"convert", in("c.raw"), in("c.kiln"), "--dims", "60,50,70", "--type", "u16", "--brick-size", "16"});
  // The filter of pixels takes some rows for each thread.
  const std::vector<std::string> view = {"--size", "120x90",       "--view", "left",      "--zoom",
                                         "2",      "--visibility", "none",   "--threads", "1"};
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"render", in("c.kiln")});
    arguments.insert(arguments.end(), view.begin(), view.end());
    return runTool(arguments);
  };
  const ToolResult dry = run({"--dry-run", "--stats", in("d.json")});
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_EQ(listing(), (std::vector<std::string>{"c.kiln", "c.raw", "d.json"}));
  const Json cost = Json::parse(readTextFile(in("d.json")));
  ASSERT_EQ(run({"-o", in("p.png"), "--stats", in("s.json")}).exit_code, 0);
  const Json stats = Json::parse(readTextFile(in("s.json")));
  EXPECT_LT(cost["bricks"]["in_view"], cost["bricks"]["interesting"]);
  for (const char* key : {"total", "interesting"}) EXPECT_EQ(cost["bricks"][key], stats["bricks"][key]) << key;
  EXPECT_EQ(cost["bricks"]["files_in_view"], stats["bricks"]["read"]);
  EXPECT_EQ(cost["bricks"]["file_bytes_in_view"], stats["bricks"]["read_bytes"]);
  for (const char* key : {"framebuffer_bytes", "visibility_bytes", "index_bytes", "shadows_bytes", "budget_bytes"})
    EXPECT_EQ(cost["memory"][key], stats["memory"][key]) << key;
  const auto image_bytes = cost["memory"]["framebuffer_bytes"].get<std::uint64_t>();
  EXPECT_GT(image_bytes, 120 * 90 * 16);
  EXPECT_LT(image_bytes, 120 * 90 * 24);
  EXPECT_LE(stats["memory"]["peak_cache_bytes"], cost["bricks"]["decoded_bytes_in_view"].get<std::uint64_t>() +
                                                     cost["memory"]["brick_bytes"].get<std::uint64_t>());
  // Lights see all bricks that show something, also bricks beside the frame.
  const std::vector<std::string> lit = {"--look", "studio"};
  const auto runLit = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), lit.begin(), lit.end());
    return run(arguments);
  };
  ASSERT_EQ(runLit({"--dry-run", "--stats", in("dl.json")}).exit_code, 0);
  ASSERT_EQ(runLit({"-o", in("l.png"), "--stats", in("sl.json")}).exit_code, 0);
  const Json lit_cost = Json::parse(readTextFile(in("dl.json"))), lit_stats = Json::parse(readTextFile(in("sl.json")));
  EXPECT_EQ(cost["bricks"]["of_lights"], 0);
  EXPECT_EQ(lit_cost["bricks"]["of_lights"], cost["bricks"]["interesting"]);
  EXPECT_EQ(lit_cost["bricks"]["files_of_lights"], lit_stats["bricks"]["read"]);
  EXPECT_EQ(lit_cost["bricks"]["file_bytes_of_lights"], lit_stats["bricks"]["read_bytes"]);
  // Another visibility method has another data structure: the printed memory holds for the chosen method.
  const std::uint64_t smallest = (cost["memory"]["smallest_bytes"].get<std::uint64_t>() + (1u << 20) - 1) >> 20;
  EXPECT_NE(dry.out.find(fmt::format("--memory {}M is the smallest that works", smallest)), std::string::npos)
      << dry.out;
  const auto with = [&](std::uint64_t megabytes, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--memory", fmt::format("{}M", megabytes)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  // Checkpointed tiles take more memory.
  const std::vector<std::string> in_tiles = {"-o", in("t.png"), "--checkpoint"};
  std::string said = with(4096, {"--dry-run", "--checkpoint"}).out;
  said.erase(0, said.find("--memory ") + 9);
  const std::uint64_t of_tiles = std::stoull(said);
  EXPECT_GT(of_tiles, smallest);
  EXPECT_EQ(with(of_tiles, in_tiles).exit_code, 0);
  EXPECT_EQ(with(of_tiles - 1, in_tiles).exit_code, 1);
  EXPECT_EQ(readFile(in("t.png")).size(), readFile(in("p.png")).size());
  EXPECT_EQ(with(smallest, {"-o", in("q.png")}).exit_code, 0);
  EXPECT_EQ(readFile(in("p.png")), readFile(in("q.png")));
  for (const std::vector<std::string>& more : {std::vector<std::string>{"-o", in("q.png")}, {"--dry-run"}}) {
    const ToolResult little = with(smallest - 1, more);
    EXPECT_EQ(little.exit_code, 1);
    EXPECT_EQ(little.errorLines().size(), 1u) << little.err;
    for (const std::string& mention : {std::string("--memory"), fmt::format("{}M is the smallest", smallest),
                                       formatBytes(image_bytes) + " of image", std::string("to read one brick")})
      EXPECT_NE(little.err.find(mention), std::string::npos) << little.err;
  }
}

// Known because the store beside the file is made once, and made again when the file or its description has changed.
TEST_F(Cli, RenderOfAForeignFile) {
  writeRamp();
  std::vector<std::string> arguments = {"render", in("v.raw"), "-o",       in("p.png"), "--size",
                                        "16x16",  "--dims",    "24,20,16", "--type",    "u8"};
  const fs::path store = in("v.raw.kiln");
  EXPECT_NE(expectDone(arguments).err.find("kiln: converting to the store " + store.string()), std::string::npos);
  EXPECT_TRUE(isStore(store));
  EXPECT_NE(expectDone(arguments).err.find("kiln: using the store " + store.string()), std::string::npos);
  // A later write of the source, however coarse the clock of the file system is.
  fs::last_write_time(in("v.raw"), fs::last_write_time(store / "manifest.json") + std::chrono::milliseconds(5));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_NE(expectDone(arguments).err.find("kiln: converting"), std::string::npos);
  EXPECT_NE(expectDone(arguments).err.find("kiln: using"), std::string::npos);
  arguments[7] = "20,24,16";
  EXPECT_NE(expectDone(arguments).err.find("kiln: converting"), std::string::npos);
  EXPECT_EQ(StoreReader(store).manifest().geometry().dims, (Extent3{20, 24, 16}));
  EXPECT_EQ(listing(), (std::vector<std::string>{"p.png", "v.raw", "v.raw.kiln"}));
}

// Known because the store belongs to the user: it has spacings that the file lacks.
TEST_F(Cli, RenderOfAForeignFileReplacesNoStoreThatItDidNotMake) {
  writeRamp();
  const std::vector<std::string> shape = {"--dims", "24,20,16", "--type", "u8"};
  std::vector<std::string> convert = {"convert", in("v.raw"), in("v.raw.kiln"), "--spacing", "1,1,2"};
  std::vector<std::string> render = {"render", in("v.raw"), "-o", in("p.png"), "--size", "16x16"};
  convert.insert(convert.end(), shape.begin(), shape.end());
  render.insert(render.end(), shape.begin(), shape.end());
  expectDone(convert);
  expectRefused(render, 1, {in("v.raw.kiln"), "another name"});
  EXPECT_EQ(StoreReader(in("v.raw.kiln")).manifest().geometry().spacing().z, 2);
  // With an equal description, the store is used.
  render.insert(render.end(), {"--spacing", "1,1,2"});
  EXPECT_NE(expectDone(render).err.find("kiln: using"), std::string::npos);
  writeText(in("v.raw.kiln") + "/manifest.json", "{}");
  expectRefused(render, 1, {in("v.raw.kiln"), "another name"});
  fs::remove(in("v.raw.kiln") + "/manifest.json");
  Journal(
      in("v.raw.kiln"), {"a volume", "kiln convert v.raw v.raw.kiln", ""}, [](const FinishedBrick&) { return true; },
      FileSystem::real());
  expectRefused(render, 1, {in("v.raw.kiln"), "--resume: kiln convert v.raw v.raw.kiln"});
  fs::remove_all(in("v.raw.kiln"));
  expectDone(render);
  EXPECT_EQ(listing(), (std::vector<std::string>{"p.png", "v.raw", "v.raw.kiln"}));
}

// Known because the first voxel is 1, followed by 11, read as 16 bits in either byte order; a header is skipped.
TEST_F(Cli, RenderOfAForeignFileWithOtherByteOrderOrHeader) {
  writeRamp();
  const fs::path store = in("v.raw.kiln");
  const std::vector<std::string> plain = {"render", in("v.raw"), "-o",       in("p.png"), "--size",
                                          "16x16",  "--dims",    "12,20,16", "--type",    "u16"};
  const auto with = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = plain;
    arguments.insert(arguments.end(), options.begin(), options.end());
    return arguments;
  };
  const auto expectConverted = [&](const std::vector<std::string>& options, int low, int high) {
    EXPECT_NE(expectDone(with(options)).err.find("kiln: converting"), std::string::npos);
    EXPECT_NE(expectDone(with(options)).err.find("kiln: using"), std::string::npos);
    // Outside the volume a brick repeats the nearest voxel, so its first voxel is the volume's first.
    const auto voxels = StoreReader(store).read({0, {0, 0, 0}}).voxels;
    EXPECT_EQ(std::to_integer<int>(voxels[0]), low);
    EXPECT_EQ(std::to_integer<int>(voxels[1]), high);
  };
  expectConverted({}, 1, 11);
  expectConverted({"--endian", "big"}, 11, 1);
  expectConverted({"--endian", "little"}, 1, 11);
  // A copy with the old file's time and four bytes in front of the voxels.
  const auto time = fs::last_write_time(in("v.raw"));
  writeText(in("v.raw"), "head" + readTextFile(in("v.raw")));
  fs::last_write_time(in("v.raw"), time);
  expectConverted({"--skip", "4"}, 1, 11);
  EXPECT_NE(expectDone({"info", store.string()}).out.find("raw, 4 bytes skipped"), std::string::npos);
}

// --- Errors ---

// Known because none of these command lines has a meaning; no file is made.
TEST_F(Cli, WrongCommandLines) {
  makeRampStore();
  const std::string store = in("v.kiln"), picture = in("p.png"), raw = in("v.raw");
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong = {
      {{}, "subcommand"},
      {{"frobnicate"}, "frobnicate"},
      {{"info"}, "STORE"},
      {{"info", store, "--frobnicate"}, "--frobnicate"},
      {{"info", store, "--store", in("stores")}, "--store applies to volume files only"},
      {{"info", store, "--unit", "mm"}, "--up-axis or --unit applies to volume files only"},
      {{"tf", store, "--store", in("stores")}, "--store applies to volume files only"},
      {{"tf", "fire", "--store", in("stores")}, "'fire' is no volume file"},
      {{"render", store, "-o", picture, "--store", in("stores")}, "--store applies to volume files only"},
      {{"render", store, "--add", store, "-o", picture, "--store", in("stores")},
       "every volume of this job is a store"},
      {{"view", store, "--no-browser", "--store", in("stores")}, "--store applies to volume files only"},
      {{"slice", store, "-o", picture, "--store", in("stores")}, "--store applies to volume files only"},
      {{"gallery", store, "-o", picture, "--store", in("stores")}, "--store applies to volume files only"},
      {{"slice", "phantom:head", "-o", picture, "--flip", "x"}, "is computed and not a file"},
      {{"gallery", "phantom:head", "-o", picture, "--store", in("stores")}, "is computed and not a file"},
      {{"render", store, "-o", picture, "--size="}, "--size: is empty"},
      {{"render", store}, "-o"},
      {{"render", store, "-o", picture, "--size", "40"}, "--size"},
      {{"render", store, "-o", picture, "--projection", "fisheye"}, "--projection"},
      {{"render", store, "-o", picture, "--view", "inside"}, "--view"},
      {{"render", store, "-o", picture, "--visibility", "xray"}, "--visibility"},
      {{"render", store, "-o", picture, "--eye", "1,2"}, "--eye"},
      {{"render", store, "-o", picture, "--eye", "1,2,nan"}, "--eye"},
      {{"render", store, "-o", picture, "--tf", "nosuch"}, "--tf"},
      {{"render", store, "-o", picture, "--opacity-threshold", "1.5"}, "--opacity-threshold"},
      {{"render", store, "-o", picture, "--repeat", "0"}, "--repeat"},
      {{"render", store, "-o", picture, "--png-bits", "12"}, "--png-bits"},
      {{"render", store, "-o", picture, "--memory", "lots"}, "lots"},
      {{"render", store, "-o", picture, "--threads", "many"}, "--threads"},
      {{"render", store, "-o", picture, "--level", "7"}, "has 2 levels, from 0 to 1"},
      {{"render", store, "-o", picture, "--level", "fine"}, "--level: expected auto"},
      {{"slice", store, "-o", picture, "--axis", "w"}, "--axis"},
      {{"slice", store, "-o", picture, "--index", "16"}, "index"},
      {{"slice", store, "-o", picture, "--window", "3"}, "--window"},
      {{"slice", store, "-o", picture, "--level", "2"}, "there is no level 2; it has 2 levels, from 0 to 1"},
      {{"slice", store, "-o", picture, "--memory", "abc"}, "--memory: 'abc' is not an amount"},
      {{"slice", "", "-o", picture}, "STORE: is empty"},
      {{"render", store, "-o", picture, "--tf", ""}, "--tf: is empty"},
      {{"render", store, "-o", picture, "--size", "70000x10"}, "from 1 to 65536 pixels"},
      {{"render", store, "-o", picture, "--threads", "-1"},
       "--threads: expected a whole number from 0 to 4096, found '-1'"},
      {{"render", store, "-o", picture, "--interocular", "3"}, "add --stereo"},
      {{"render", store, "-o", in("p_%V.png")}, "add --stereo"},
      {{"render", store, "-o", picture, "--rate", "30"}, "--rate: no video is made"},
      {{"render", store, "-o", picture, "--stats", picture}, "--stats: " + picture},
      {{"render", store, "-o", picture, "--stats", in("s"), "--trace", in("s")}, "--trace: " + in("s")},
      {{"export", store, in("v.xyz")}, "write .nrrd, .nii.gz"},
      {{"convert", raw, in("n.kiln"), "--skip", "-5"}, "--skip: expected a whole number from 0 on, found '-5'"},
      {{"convert", raw, in("n.kiln"), "--levels", "0"}, "--levels: expected a whole number from 1 on, found '0'"},
      {{"convert", store, in("n.kiln")}, "is a store already"},
      {{"export", store, in("v.vdb"), "--level", "7"}, "there is no level 7"},
      {{"convert", raw, in("n.kiln")}, "--dims"},
      {{"convert", raw, in("n.kiln"), "--dims", "24,20,16", "--type", "u12"}, "--type"},
      {{"convert", raw, in("n.kiln"), "--dims", "24,0,16", "--type", "u8"}, "--dims"},
      {{"convert", raw, in("n.kiln"), "--dims", "24,20,16", "--type", "u8", "--endian", "middle"}, "--endian"},
      {{"convert", raw, in("n.kiln"), "--dims", "24,20,16", "--type", "u8", "--brick-size", "12"}, "--brick-size"},
      {{"convert", raw, in("n.kiln"), "--dims", "24,20,16", "--type", "u8", "--spacing", "1,-1,1"}, "--spacing"},
  };
  for (const auto& [arguments, mention] : wrong) expectRefused(arguments, 2, {mention});
  EXPECT_EQ(listing(), (std::vector<std::string>{"v.kiln", "v.raw"}));
}

// Known because the name is wrong before any work is done: not even the store of a foreign file is made.
TEST_F(Cli, APictureOfAnUnknownKindIsRefusedFirst) {
  writeRamp();
  expectRefused({"render", in("v.raw"), "-o", in("p.jpeg"), "--dims", "24,20,16", "--type", "u8"}, 2, {"p.jpeg"});
  expectRefused({"slice", in("none.kiln"), "-o", in("p.gif")}, 2, {"p.gif"});
  expectRefused({"compare", in("none.png"), in("none.png"), "-o", in("d.txt")}, 2, {"d.txt"});
  EXPECT_EQ(listing(), std::vector<std::string>{"v.raw"});
}

// Known because the files do not exist.
TEST_F(Cli, MissingFiles) {
  makeRampStore();
  expectRefused({"convert", in("none.nrrd"), in("n.kiln")}, 1, {in("none.nrrd")});
  for (const char* command : {"info", "verify"}) expectRefused({command, in("none.kiln")}, 1, {in("none.kiln")});
  expectRefused({"render", in("none.kiln"), "-o", in("p.png")}, 1, {in("none.kiln")});
  for (const std::vector<std::string>& options : {std::vector<std::string>{"--store", in("s")}, {"--flip", "x"}}) {
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"info"}, {"slice", "-o", in("p.png")}, {"gallery", "-o", in("p.png")}}) {
      std::vector<std::string> arguments = command;
      arguments.push_back(in("none.kiln"));
      arguments.insert(arguments.end(), options.begin(), options.end());
      expectRefused(arguments, 1, {in("none.kiln") + ": there is no such file or store"});
    }
  }
  expectRefused({"render", in("none.json"), "-o", in("p.png")}, 1, {in("none.json")});
  expectRefused({"export", in("none.kiln"), in("v.vdb")}, 1, {in("none.kiln")});
  expectRefused({"export", in("v.kiln"), in("none/s_##.tif")}, 1,
                {in("none/s_##.tif") + ": cannot be made: there is no directory " + in("none")});
  expectRefused({"compare", in("none.png"), in("none.png")}, 1, {in("none.png")});
  expectRefused({"render", in("v.kiln"), "-o", in("nowhere/p.png"), "--size", "8x8"}, 1, {in("nowhere/p.png")});
  fs::create_directory(in("empty"));
  expectRefused({"convert", in("empty"), in("n.kiln")}, 1, {in("empty")});
  expectRefused({"info", in("empty")}, 1, {in("empty")});
  EXPECT_EQ(listing(), (std::vector<std::string>{"empty", "v.kiln", "v.raw"}));
}

// Known because each header contradicts its file, the format, or arithmetic.
TEST_F(Cli, WrongVolumes) {
  const std::string rest = "encoding: raw\nendian: little\n\n";
  writeText(in("short.nrrd"), "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 8 8 8\n" + rest + std::string(1000, 'x'));
  writeText(in("huge.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\n" + rest +
                                 std::string(1000, 'x'));
  writeText(in("large.nrrd"), "NRRD0004\ntype: float\ndimension: 3\nsizes: 2000000000 2000000000 2000000000\n" + rest +
                                  std::string(1000, 'x'));
  writeText(in("type.nrrd"), "NRRD0004\ntype: foo\ndimension: 3\nsizes: 8 8 8\n" + rest + std::string(1000, 'x'));
  writeText(in("empty.nrrd"), "");
  writeText(in("noise.bin"), std::string("\x7f\x01\x02\x00\xff", 5));
  for (const char* name : {"short.nrrd", "huge.nrrd", "large.nrrd", "type.nrrd", "empty.nrrd"})
    expectRefused({"convert", in(name), in("n.kiln")}, 1, {in(name)});
  expectRefused({"convert", in("noise.bin"), in("n.kiln"), "--dims", "8,8,8", "--type", "u8"}, 1, {in("noise.bin")});
  expectRefused(
      {"convert", in("noise.bin"), in("n.kiln"), "--dims", "2147483647,2147483647,2147483647", "--type", "f64"}, 1,
      {in("noise.bin")});
  EXPECT_FALSE(fs::exists(in("n.kiln")));
}

// Known because an output is replaced only on request, and only if it is a store.
TEST_F(Cli, OutputsThatExist) {
  makeRampStore();
  std::vector<std::string> arguments = {"convert", in("v.raw"), in("v.kiln"), "--dims", "24,20,16", "--type", "u8"};
  expectRefused(arguments, 1, {in("v.kiln"), "--overwrite"});
  arguments.push_back("--overwrite");
  arguments[2] = in("v.raw");
  expectRefused(arguments, 1, {in("v.raw")});
  writeText(in("v.vdb"), "mine");
  expectRefused({"export", in("v.kiln"), in("v.vdb")}, 1, {in("v.vdb")});
  EXPECT_EQ(readTextFile(in("v.vdb")), "mine");
  expectDone({"verify", in("v.kiln")});
}

// Known because 100 bytes hold no brick; the message names the memory that does.
TEST_F(Cli, TooLittleMemory) {
  makeRampStore();
  expectRefused({"convert", in("v.raw"), in("n.kiln"), "--dims", "24,20,16", "--type", "u8", "--memory", "100"}, 1,
                {"--memory", "smallest", "MiB"});
  expectRefused({"verify", in("v.kiln"), "--memory", "100"}, 1, {"--memory", "KiB"});
  const ToolResult result =
      expectRefused({"render", in("v.kiln"), "-o", in("p.png"), "--size", "8x8", "--memory", "100"}, 1, {"memory"});
  EXPECT_TRUE(result.err.find("KiB") != std::string::npos || result.err.find("MiB") != std::string::npos) << result.err;
  EXPECT_EQ(listing(), (std::vector<std::string>{"v.kiln", "v.raw"}));
}

// Known because no brick of noise fits into 4096 bytes, and /dev/full holds nothing.
TEST_F(Cli, NoSpaceLeft) {
  const DenseVolume volume = noise({{40, 40, 40}, VoxelType::u8}, 1, {0, 255});
  writeText(in("n.raw"), textOf(volume.voxels));
  ToolOptions full;
  full.file_bytes = 4096;
  expectRefused({"convert", in("n.raw"), in("n.kiln"), "--dims", "40,40,40", "--type", "u8"}, 1,
                {in("n.kiln"), "free space"}, full);
  EXPECT_EQ(listing(), std::vector<std::string>{"n.raw"});
  expectDone({"convert", in("n.raw"), in("n.kiln"), "--dims", "40,40,40", "--type", "u8"});
  expectDone({"export", in("n.kiln"), in("n.vdb")});
  const std::string whole = readTextFile(in("n.vdb"));
  expectRefused({"export", in("n.kiln"), in("n.vdb"), "--overwrite"}, 1, {in("n.vdb"), "free space"}, full);
  EXPECT_EQ(readTextFile(in("n.vdb")), whole);
  fs::remove(in("n.vdb"));
  // Noise in every pixel: no picture of 40 x 40 such pixels is shorter than the limit.
  full.file_bytes = 512;
  for (const char* const name : {"p.png", "p.tif", "p.jpg"})
    expectRefused({"slice", in("n.kiln"), "-o", in(name)}, 1, {in(name), "free space"}, full);
  if (fs::exists("/dev/full")) {
    // Through a link, so that a program that replaces its output replaces only the link.
    fs::create_symlink("/dev/full", in("full.json"));
    expectRefused({"render", in("n.kiln"), "-o", in("p.png"), "--size", "8x8", "--stats", in("full.json")}, 1,
                  {in("full.json"), "free space"});
    EXPECT_TRUE(fs::is_symlink(in("full.json")));
    fs::remove(in("full.json"));
    fs::remove(in("p.png"));
  }
  EXPECT_EQ(listing(), (std::vector<std::string>{"n.kiln", "n.raw"}));
}

// Known because /dev/full accepts nothing: a script must detect an incomplete answer.
TEST_F(Cli, AnAnswerThatCannotBeWrittenIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "/dev/full is not there";
  makeRampStore();
  const std::string store = in("v.kiln"), picture = in("p.png"), said = in("said");
  for (const std::string& arguments : {std::string("--help"), "info " + store, std::string("schema"),
                                       "render " + store + " -o " + picture + " --size 8x8 --progress json"}) {
    const std::string command = std::string(KILN_TOOL) + " " + arguments + " 2> " + said + " > ";
    EXPECT_EQ(std::system((command + "/dev/null").c_str()), 0) << arguments;
    const int status = std::system((command + "/dev/full").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << arguments;
    EXPECT_EQ(readTextFile(said), "kiln: standard output: could not be written to its end; is the disk full?\n")
        << arguments;
  }
}

// Known because a misread job or transfer function would draw another picture: unknown keys are errors.
TEST_F(Cli, WrongJobsAndTransferFunctions) {
  makeRampStore();
  const auto job = [&](const std::string& text, int exit_code, const std::string& mention) {
    writeText(in("job.json"), text);
    expectRefused({"render", in("job.json"), "-o", in("p.png"), "--size", "8x8"}, exit_code, {"job.json", mention});
  };
  job(R"({"kiln": 1, "volume": "v.kiln", "camera": {"fow": 60}})", 2, "fow");
  job(R"({"kiln": 1, "volume": "v.kiln", "novelty": 1})", 2, "novelty");
  job(R"({"kiln": 1, "volume": "v.kiln", )", 1, "line 1");
  job("", 1, "job.json");
  const auto transfer = [&](const std::string& text, int exit_code, const std::string& mention) {
    writeText(in("tf.json"), text);
    expectRefused({"render", in("v.kiln"), "-o", in("p.png"), "--size", "8x8", "--tf", in("tf.json")}, exit_code,
                  {"tf.json", mention});
  };
  transfer(R"({"points": [{"value": 1, "color": [1, 0, 0]}]})", 2, "opacity");
  transfer(R"({"points": [{"value": 1, "color": [1, 0], "opacity": 1}]})", 2, "color");
  transfer(R"({"points": [], "units": 1})", 2, "units");
  transfer(R"({"points": [})", 1, "line 1");
  EXPECT_FALSE(fs::exists(in("p.png")));
}

// Known because one bit of a brick has been flipped.
TEST_F(Cli, ADamagedStoreIsNamed) {
  makeRampStore();
  const std::string brick = in("v.kiln") + "/bricks/0/1_0_0.vdb";
  std::vector<std::byte> data = readFile(brick);
  data[data.size() / 2] ^= std::byte{4};
  writeText(brick, textOf(data));
  expectDone({"info", in("v.kiln")});
  const std::string other = in("v.kiln") + "/bricks/0/0_1_0.vdb";
  const std::vector<std::byte> whole = readFile(other);
  fs::remove(other);
  const ToolResult verify = runTool({"verify", in("v.kiln"), "--threads", "1"});
  EXPECT_EQ(verify.exit_code, 1);
  EXPECT_EQ(verify.out, "");
  const std::vector<std::string> lines = verify.errorLines();
  ASSERT_EQ(lines.size(), 3u) << verify.err;
  EXPECT_EQ(lines[0].find("kiln: " + brick + ": checksum "), 0u) << lines[0];
  EXPECT_EQ(lines[1].find("kiln: " + other + ": is missing, expected "), 0u) << lines[1];
  EXPECT_EQ(lines[2], "kiln: " + in("v.kiln") + ": 2 of 7 files damaged");
  writeText(other, textOf(whole));
  expectRefused({"render", in("v.kiln"), "-o", in("p.png"), "--size", "8x8", "--visibility", "none", "--level", "0"}, 1,
                {brick, "checksum"});
  expectRefused({"export", in("v.kiln"), in("v.vdb")}, 1, {brick, "checksum"});
  fs::remove(in("v.kiln") + "/manifest.json");
  expectRefused({"info", in("v.kiln")}, 1, {in("v.kiln"), "did not finish"});
  EXPECT_EQ(listing(), (std::vector<std::string>{"v.kiln", "v.raw"}));
}

// Known because a brick is missing: the picture differs, and the brick is reported once, for any number of frames and
// readers.
TEST_F(Cli, DamagedBricksAreSkippedWhereAskedFor) {
  makeRampStore();
  const auto draw = [&](const std::string& picture, const std::vector<std::string>& more) {
    // A camera that fits what is visible reads bricks, too.
    std::vector<std::string> arguments = {"render", in("v.kiln"),   "-o",   in(picture), "--size",
                                          "40x40",  "--visibility", "none", "--fit",     "box"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return expectDone(arguments);
  };
  draw("whole.exr", {});
  EXPECT_EQ(draw("same.exr", {"--skip-damaged"}).err, "");
  EXPECT_EQ(readFile(in("same.exr")), readFile(in("whole.exr")));
  const std::string brick = in("v.kiln") + "/bricks/0/1_0_0.vdb";
  fs::remove(brick);
  for (const char* threads : {"1", "2"}) {
    const ToolResult result =
        draw("part.exr", {"--skip-damaged", "--repeat", "3", "--threads", threads, "--stats", in("s.json")});
    const std::vector<std::string> lines = result.errorLines();
    ASSERT_EQ(lines.size(), 2u) << result.err;
    EXPECT_EQ(lines[0].find("kiln: warning: drawn without " + brick + ": is missing, expected "), 0u) << lines[0];
    EXPECT_EQ(lines[1].find("kiln: warning: 1 damaged brick is missing from the picture"), 0u) << lines[1];
    const Json stats = Json::parse(readTextFile(in("s.json")));
    EXPECT_EQ(stats["bricks"]["damaged"], 1);
    for (const Json& frame : stats["frames"]) EXPECT_EQ(frame["bricks"]["damaged"], 1);
    EXPECT_EQ(readImageText(in("part.exr")).at("kiln:damagedBricks"), "1");
  }
  EXPECT_GT(compareImages(readImage(in("whole.exr")), readImage(in("part.exr"))).differing, 0u);
  writeText(in("job.json"), R"({"kiln": 1, "volume": "v.kiln", "output": "p.exr", "skipDamaged": true,
    "image": {"width": 40, "height": 40}, "visibility": {"method": "none"}, "camera": {"fit": "box"}})");
  EXPECT_EQ(expectDone({"render", in("job.json")}).errorLines().size(), 2u);
  EXPECT_EQ(readFile(in("p.exr")), readFile(in("part.exr")));
  // A composited picture reports damage found in any of its parts, and their owners and comments.
  for (const std::string part : {"1", "2", "3"})
    draw("p" + part + ".exr", {"--skip-damaged", "--lattice", "ray", "--part", part + "/3", "--owner", "we",
                               "--comments", "take " + std::string(part == "1" ? "1" : "2")});
  expectDone({"composite", in("p1.exr"), in("p2.exr"), in("p3.exr"), "-o", in("made.exr")});
  const std::map<std::string, std::string> made = readImageText(in("made.exr"));
  EXPECT_GE(std::stoi(made.at("kiln:damagedBricks")), 1);
  EXPECT_EQ(made.at("owner"), "we");
  EXPECT_EQ(made.at("comments"), "take 1; take 2");
  // A damaged index cannot be skipped.
  fs::remove(in("v.kiln") + "/index.bin");
  expectRefused({"render", in("job.json")}, 1, {"index.bin", "is missing"});
}

// Known because SIGINT stops the work, and unfinished work is no store.
TEST_F(Cli, AnInterruptLeavesWhatCanBeResumed) {
  constexpr std::size_t kBytes = 256u * 512 * 512;
  std::string data(kBytes, '\0');
  for (std::size_t i = 0; i < kBytes; i += 8) {
    const std::uint64_t bits = hashBits(9, i);
    std::memcpy(data.data() + i, &bits, 8);
  }
  writeText(in("big.raw"), data);
  ToolOptions options;
  options.seconds = 300;
  options.interrupt_when = [bricks = fs::path(in("big.kiln")) / "bricks" / "0"] {
    std::error_code ignored;
    return fs::exists(bricks, ignored) && !fs::is_empty(bricks, ignored);
  };
  std::vector<std::string> convert = {"convert", in("big.raw"), in("big.kiln"), "--dims", "256,512,512",
                                      "--type",  "u8",          "--brick-size", "64"};
  ToolResult result = runTool(convert, options);
  // A conversion that ends before the signal arrives is repeated.
  for (int tries = 1; tries < 5 && result.exit_code == 0; ++tries) {
    fs::remove_all(in("big.kiln"));
    result = runTool(convert, options);
  }
  EXPECT_TRUE(result.interrupted);
  EXPECT_EQ(result.exit_code, 1) << result.err;
  ASSERT_EQ(result.errorLines().size(), 2u) << result.err;
  EXPECT_NE(result.errorLines()[0].find("--resume"), std::string::npos) << result.err;
  EXPECT_EQ(result.errorLines()[1], "kiln: interrupted while converting");
  expectRefused({"info", in("big.kiln")}, 1, {"did not finish"});
  expectRefused(convert, 1, {"--resume"});
  convert.push_back("--resume");
  const ToolResult resumed = expectDone(convert);
  EXPECT_EQ(resumed.err.find(in("big.kiln") + ": "), resumed.err.find("kiln: ") + 6) << resumed.err;
  EXPECT_NE(resumed.err.find("are finished already"), std::string::npos) << resumed.err;
  expectDone({"verify", in("big.kiln")});
  EXPECT_NE(expectDone(convert).err.find("finished already"), std::string::npos);
  convert[8] = "128";
  expectRefused(convert, 1, {"with bricks of", "--overwrite"});
  fs::remove(in("big.raw"));
  EXPECT_EQ(listing(), std::vector<std::string>{"big.kiln"});
}

// Known because a half has 11 bits: 4097 lies between 4096 and 4100, as do its odd neighbours; 10 is exact.
TEST_F(Cli, HalfIsLossyAndSaysSo) {
  const std::uint16_t values[] = {10, 4097, 65535, 2049};
  writeText(in("v.raw"), {reinterpret_cast<const char*>(values), sizeof values});
  const std::vector<std::string> raw = {"convert", in("v.raw"), in("v.kiln"), "--dims", "4,1,1", "--type", "u16"};
  std::vector<std::string> half = raw;
  half.push_back("--half");
  EXPECT_NE(expectDone(half).out.find("no value changed by more than 31"), std::string::npos);
  const BrickBlock block = StoreReader(in("v.kiln")).read({0, {0, 0, 0}});
  const std::uint16_t* found = block.data<std::uint16_t>() + block.offsetOf({0, 0, 0});
  EXPECT_EQ(std::vector(found, found + 4), (std::vector<std::uint16_t>{10, 4096, 65504, 2048}));
  expectRefused({"convert", in("v.raw"), in("w.kiln"), "--dims", "2,1,1", "--type", "u32", "--half"}, 2, {"--half"});
}

// Known because the conversion follows. Its size agrees with samples of the noise within a tenth, its buffers with the
// plan, and a dry run leaves no files. A stream has no samples and stays below the bound.
TEST_F(Cli, ADryRunForetellsTheConversion) {
  const DenseVolume volume = noise({{60, 50, 70}, VoxelType::u16}, 3, usualRange(VoxelType::u16));
  writeText(in("c.raw"), textOf(volume.voxels));
  writeText(in("c.nrrd"), "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 60 50 70\nencoding: gzip\nendian: little\n\n" +
                              gzipped(textOf(volume.voxels)));
  // Returns the amount of memory printed after some words.
  const auto amountAfter = [](const std::string& text, const std::string& words) {
    const std::size_t at = text.find(words);
    EXPECT_NE(at, std::string::npos) << "'" << words << "' is not in: " << text;
    std::string number, unit;
    std::istringstream(at == std::string::npos ? "0 K" : text.substr(at + words.size())) >> number >> unit;
    return static_cast<double>(parseBytes(number + unit));
  };
  for (const bool stream : {false, true}) {
    std::vector<std::string> arguments = {"convert", in(stream ? "c.nrrd" : "c.raw"), "--brick-size", "16"};
    if (!stream) arguments.insert(arguments.end(), {"--dims", "60,50,70", "--type", "u16"});
    std::vector<std::string> dry = arguments;
    dry.push_back("--dry-run");
    const std::string foretold = expectDone(dry).out;
    EXPECT_EQ(listing(), (std::vector<std::string>{"c.nrrd", "c.raw"}));
    arguments.push_back(in("c.kiln"));
    const std::string done = expectDone(arguments).out;
    const double written =
        Json::parse(expectDone({"info", in("c.kiln"), "--json"}).out)["storage"]["diskBytes"].get<double>();
    EXPECT_EQ(amountAfter(foretold, "memory       up to "), amountAfter(done, "buffers up to "));
    EXPECT_NE(foretold.find("scratch      none"), std::string::npos) << foretold;
    EXPECT_NE(foretold.find(stream ? "1 pass, in order, through a window of" : "1 pass, in boxes"), std::string::npos)
        << foretold;
    EXPECT_NEAR(amountAfter(foretold, "writing      about ") / written, 1, 0.1) << foretold;
    EXPECT_NE(foretold.find(stream ? "bricks of the first 22 slices" : "8 of them"), std::string::npos) << foretold;
    EXPECT_NE(foretold.find("million voxels/s"), std::string::npos) << foretold;
    fs::remove_all(in("c.kiln"));
  }
  expectRefused({"convert", in("c.nrrd")}, 2, {"OUT"});
}

// Known because 1024 and 1025 are halves and their mean, 1024.5, lies between: ties round to even.
TEST_F(Cli, HalfHoldsOnEveryLevel) {
  std::vector<float> values(16 * 2 * 2, 1024);
  for (std::size_t i = 0; i < values.size(); i += 2) values[i] = 1025;
  writeText(in("v.raw"), {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)});
  const auto convert = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"convert", in("v.raw"), in(name),       "--dims", "16,2,2",
                                          "--type",  "f32",       "--brick-size", "8"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return expectDone(arguments).out;
  };
  const auto coarse = [&](const std::string& name) {
    const BrickBlock block = StoreReader(in(name)).read({1, {0, 0, 0}});
    return block.data<float>()[block.offsetOf({1, 0, 0})];
  };
  convert("exact.kiln", {});
  EXPECT_EQ(coarse("exact.kiln"), 1024.5f);
  EXPECT_NE(convert("half.kiln", {"--half"})
                .find("no value changed by more than 0, no mean of a coarser level by more than 0.5"),
            std::string::npos);
  EXPECT_EQ(coarse("half.kiln"), 1024);
}

// Returns the files of a store without the time of conversion.
std::map<std::string, std::vector<std::byte>> filesWithoutTime(const fs::path& store) {
  auto files = filesOf(store);
  Json manifest = Json::parse(readTextFile(store / "manifest.json"));
  manifest.erase("checksum");
  manifest["source"].erase("time");
  manifest["source"].erase("command");
  const std::string text = manifest.dump();
  const auto bytes = std::as_bytes(std::span(text));
  files["manifest.json"].assign(bytes.begin(), bytes.end());
  return files;
}

// Kills conversions at seeded instants between start and end, and resumes them. Known because a store is determined by
// its brick files, which are compared.
class CliKilled : public Cli {
 protected:
  void expectResumable(int instants) {
    std::string data(96 * 96 * 96, '\0');
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<char>(hashBits(9, i / 5) % 50);
    writeText(in("v.raw"), data);
    const auto arguments = [&](const char* out) {
      return std::vector<std::string>{"convert", in("v.raw"), in(out),        "--dims", "96,96,96",
                                      "--type",  "u8",        "--brick-size", "16"};
    };
    const auto begin = std::chrono::steady_clock::now();
    expectDone(arguments("whole.kiln"));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const auto whole = filesWithoutTime(in("whole.kiln"));
    Random random(20);
    int unfinished = 0;
    for (int i = 0; i < instants; ++i) {
      ToolOptions options;
      options.seconds = seconds * static_cast<double>(random.between(1, 1000)) / 1000;
      SCOPED_TRACE("killed after " + std::to_string(options.seconds) + " s");
      fs::remove_all(in("killed.kiln"));
      std::vector<std::string> convert = arguments("killed.kiln");
      unfinished += runTool(convert, options).timed_out && !fs::exists(in("killed.kiln") + "/manifest.json");
      if (fs::exists(in("killed.kiln"))) {
        const ToolResult info = runTool({"info", in("killed.kiln")});
        EXPECT_EQ(info.exit_code == 0, fs::exists(in("killed.kiln") + "/manifest.json")) << info.err;
      }
      convert.push_back("--resume");
      expectDone(convert);
      EXPECT_TRUE(filesWithoutTime(in("killed.kiln")) == whole);
    }
    EXPECT_GT(unfinished, 0) << "every conversion was faster than its death";
  }
};

TEST_F(CliKilled, ConversionsAreResumed) { expectResumable(4); }
TEST_F(CliKilled, NightlyConversionsAreResumed) { expectResumable(20); }

}  // namespace
}  // namespace kiln::test
