// Several ranks under mpirun behave as one program: output, exit, and pictures equal to a single process's. Skipped if
// Kiln is built without MPI or mpirun is not installed.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/system/run_tool.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class Ranks : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!canRunRanks()) GTEST_SKIP() << "Kiln is built without MPI, or mpirun is not there";
  }
  static ToolResult run(int ranks, const std::vector<std::string>& arguments) {
    ToolOptions options;
    options.ranks = ranks;
    return runTool(arguments, options);
  }
};

TEST_F(Ranks, OneOfThemSpeaks) {
  EXPECT_EQ(run(3, {"--version"}).out, runTool({"--version"}).out);
  const fs::path store =
      makeStore(head({{20, 20, 20}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8)), "ranks_info", 8);
  const ToolResult info = run(3, {"info", store.string()});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(info.out, runTool({"info", store.string()}).out);
}

// mpirun adds its own sentences about the exit code.
TEST_F(Ranks, OneSentenceSaysWhatFailed) {
  const auto said = [](const ToolResult& result) {
    int out = 0;
    for (const std::string& line : result.errorLines()) out += line.starts_with("kiln:") ? 1 : 0;
    return out;
  };
  const ToolResult missing = run(3, {"info", "/nowhere.kiln"});
  EXPECT_EQ(missing.exit_code, 1) << missing.err;
  EXPECT_EQ(said(missing), 1) << missing.err;
  EXPECT_NE(missing.err.find("kiln: rank 0 of 3: /nowhere.kiln"), std::string::npos) << missing.err;
  const ToolResult wrong = run(3, {"info", "--sideways"});
  EXPECT_EQ(wrong.exit_code, 2) << wrong.err;
  EXPECT_EQ(said(wrong), 1) << wrong.err;
}

// Sends a signal to a process of the program whose command line contains the folder.
bool signalOneRank(const std::string& folder, int signal) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream file(entry.path() / "cmdline");
    const std::string words((std::istreambuf_iterator<char>(file)), {});
    if (words.starts_with(KILN_TOOL) && words.find(folder) != std::string::npos)
      return ::kill(std::stoi(name), signal) == 0;
  }
  return false;
}

class RanksRender : public Ranks {
 protected:
  void SetUp() override {
    Ranks::SetUp();
    if (IsSkipped()) return;
    directory_ =
        freshDirectory(std::string("ranks_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    for (const char* folder : {"one", "many"}) fs::create_directories(directory_ / folder);
    volume_ = (directory_ / "h.kiln").string();
    EXPECT_EQ(runTool({"convert", "phantom:head:64x64x64", volume_, "--brick-size", "16"}).exit_code, 0);
  }

  // Draws to `folder` and returns the statistics of --stats.
  nlohmann::json drawn(int ranks, const std::string& folder, std::vector<std::string> more) {
    const std::string stats = (directory_ / (folder + ".json")).string();
    std::vector<std::string> arguments = {"render", volume_, "--threads", "1", "--stats", stats};
    arguments.insert(arguments.end(), more.begin(), more.end());
    for (std::string& argument : arguments) {
      if (argument.starts_with("OUT/")) argument = (directory_ / folder / argument.substr(4)).string();
    }
    const ToolResult result = run(ranks, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(readTextFile(stats));
  }

  // Runs two ranks, each with a separate working directory and command.
  ToolResult inFolders(const std::string& first, const std::vector<std::string>& command, const std::string& second,
                       const std::vector<std::string>& other) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {":", "-n", "1", "--wdir", (directory_ / second).string(), KILN_TOOL});
    arguments.insert(arguments.end(), other.begin(), other.end());
    ToolOptions options;
    options.ranks = 1;
    options.directory = directory_ / first;
    return runTool(arguments, options);
  }

  std::string volume_;
  fs::path directory_;
};

// Known because every pixel of a crop is the whole picture's, and a frame of a sequence the still picture's.
TEST_F(RanksRender, AFrameInTilesIsTheSameToTheBit) {
  for (const std::vector<std::string>& look : std::vector<std::vector<std::string>>{
           {"-o", "OUT/a.exr", "--size", "200x150", "--tf", "ct-bone-and-skin", "--aov", "depth,normal"},
           {"-o", "OUT/b.exr", "--size", "200x220", "--crop", "10,20,150,180", "--azimuth", "30", "--background",
            "1,0,0:0,0,1", "--samples", "4", "--tf", "ct-skin"},
           {"-o", "OUT/c.exr", "--size", "200x140", "--mode", "mip", "--aov", "value"},
           {"-o", "OUT/d.exr", "--size", "200x130", "--eye", "0,0,0", "--target", "1,5,0", "--tf", "ct-skin"},
           // Bricks of volumes with companions are not sent to other ranks.
           {"-o", "OUT/e.exr", "--size", "200x130", "--color-by", volume_, "--tf", "ct-skin"}}) {
    const auto one = drawn(0, "one", look);
    const auto many = drawn(3, "many", look);
    EXPECT_TRUE(filesOf(directory_ / "one") == filesOf(directory_ / "many")) << look[1];
    EXPECT_EQ(many["shared_by"], "tiles");
    ASSERT_EQ(many["ranks"].size(), 3u);
    std::uint64_t read = 0, tiles = 0, sent = 0;
    for (const auto& rank : many["ranks"]) {
      read += rank["bricks"]["read_bytes"].get<std::uint64_t>();
      tiles += rank["tiles"].get<std::uint64_t>();
      sent += rank["sent_bytes"].get<std::uint64_t>();
      EXPECT_GE(rank["busy_s"].get<double>(), 0.0);
    }
    EXPECT_EQ(read, many["bricks"]["read_bytes"]);
    EXPECT_EQ(many["bricks"]["contributing"], one["bricks"]["contributing"]);
    EXPECT_GE(tiles, 3u);
    EXPECT_GE(sent, 200u * 130 * 16);
  }
}

TEST_F(RanksRender, FramesAreTheSameHoweverTheyAreShared) {
  const std::vector<std::string> look = {"-o", "OUT/t_##.png", "--size", "140x130", "--turntable", "8"};
  drawn(0, "one", look);
  const auto whole = filesOf(directory_ / "one");
  EXPECT_EQ(whole.size(), 8u);
  for (const char* shared_by : {"tiles", "frames"}) {
    std::vector<std::string> shared = look;
    shared.insert(shared.end(), {"--distribute", shared_by});
    const auto stats = drawn(2, "many", shared);
    EXPECT_TRUE(filesOf(directory_ / "many") == whole) << shared_by;
    EXPECT_EQ(stats["shared_by"], shared_by);
    EXPECT_EQ(stats["frames"].size(), 8u);
    // Existing pictures are kept, missing pictures are drawn.
    fs::remove(directory_ / "many/t_02.png");
    fs::resize_file(directory_ / "many/t_07.png", 100);
    shared.emplace_back("--resume");
    const auto resumed = drawn(3, "many", shared);
    EXPECT_EQ(resumed["kept"].size(), 6u);
    EXPECT_EQ(resumed["frames"].size(), 2u);
    EXPECT_TRUE(filesOf(directory_ / "many") == whole) << shared_by;
    for (const auto& entry : fs::directory_iterator(directory_ / "many")) fs::remove(entry);
  }
}

// With a thread a rank there is no read-ahead: the bricks read are the visible bricks, as in a single process, and each
// file is read once for all ranks. Without sharing, bricks visible to several ranks are read several times.
TEST_F(RanksRender, BricksThatSeveralSeeAreReadOnce) {
  std::vector<std::string> look = {"-o", "OUT/a.exr", "--size", "200x160", "--tf", "ct-bone-and-skin"};
  const auto one = drawn(0, "one", look);
  const auto sum = [](const nlohmann::json& stats, const char* what) {
    std::uint64_t out = 0;
    for (const auto& rank : stats["ranks"]) out += rank["bricks"][what].get<std::uint64_t>();
    return out;
  };
  std::vector<std::string> shared = look;
  shared.insert(shared.end(), {"--distribute", "tiles", "--share-reads"});
  shared.emplace_back("on");
  const auto on = drawn(3, "many", shared);
  EXPECT_TRUE(filesOf(directory_ / "one") == filesOf(directory_ / "many"));
  EXPECT_EQ(on["bricks"]["read"], one["bricks"]["read"]);
  EXPECT_EQ(on["bricks"]["read_bytes"], one["bricks"]["read_bytes"]);
  EXPECT_EQ(sum(on, "read_bytes"), one["bricks"]["read_bytes"]);
  EXPECT_EQ(sum(on, "received_bytes"), sum(on, "sent_bytes"));
  EXPECT_GT(on["memory"]["shared_reads_bytes"].get<std::uint64_t>(), 0u);
  shared.back() = "off";
  const auto off = drawn(3, "many", shared);
  EXPECT_TRUE(filesOf(directory_ / "one") == filesOf(directory_ / "many"));
  EXPECT_EQ(off["memory"]["shared_reads_bytes"], 0u);
  EXPECT_EQ(sum(off, "received"), 0u);
  EXPECT_GT(sum(off, "read"), sum(on, "read"));
  const ToolResult wrong =
      runTool({"render", volume_, "-o", (directory_ / "x.exr").string(), "--share-reads", "maybe"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("--share-reads: expected one of off, on, found 'maybe'"), std::string::npos) << wrong.err;
}

// A picture that is no single image of pixels is drawn by a single rank, frame by frame, and each rank writes a
// separate trace.
TEST_F(RanksRender, ViewsThatHaveNoTilesAreSharedByFrames) {
  for (const std::vector<std::string>& look : std::vector<std::vector<std::string>>{
           {"-o", "OUT/d_##.exr", "--size", "30x20", "--turntable", "2", "--deep"},
           {"-o", "OUT/e_##.exr", "--size", "30x20", "--turntable", "2", "--stereo", "both", "--interocular", "3"},
           {"-o", "OUT/p_##.exr", "--size", "24x12", "--turntable", "2", "--projection", "equirectangular"}}) {
    drawn(0, "one", look);
    std::vector<std::string> shared = look;
    const std::string trace = (directory_ / "trace.json").string();
    shared.insert(shared.end(), {"--trace", trace});
    EXPECT_EQ(drawn(2, "many", shared)["shared_by"], "frames");
    EXPECT_TRUE(filesOf(directory_ / "one") == filesOf(directory_ / "many")) << look[1];
    for (const char* name : {"trace.json", "trace.1.json"}) {
      EXPECT_GT(nlohmann::json::parse(readTextFile(directory_ / name))["traceEvents"].size(), 2u) << name;
      fs::remove(directory_ / name);
    }
  }
  for (const char* shared_by : {"tiles", "bricks"}) {
    const ToolResult refused =
        run(2, {"render", volume_, "-o", (directory_ / "x.exr").string(), "--deep", "--distribute", shared_by});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.err.find("use --distribute frames"), std::string::npos) << refused.err;
  }
}

// Known because parts that fill the volume form the whole (tests/composite/partial_image_property_test.cpp).
TEST_F(RanksRender, BricksOfEachRankMakeTheWhole) {
  const auto expectClose = [&](const std::string& name) {
    const ImageDifference difference =
        compareImages(readImage(directory_ / "one" / name), readImage(directory_ / "many" / name));
    EXPECT_LT(difference.largest, 1 / 255.0) << name;
    EXPECT_GT(difference.foreground_psnr_db, 80) << name;
  };
  const std::vector<std::vector<std::string>> looks = {
      {"-o", "OUT/a.exr", "--tf", "ct-bone-and-skin", "--background", "0.2,0.1,0", "--samples", "4", "--aov",
       "depth,normal"},
      {"-o", "OUT/b.exr", "--tf", "ct-skin", "--eye", "3,-9,5", "--target", "20,60,30", "--fov", "100", "--samples",
       "1"},
      {"-o", "OUT/c.exr", "--tf", "ct-bone", "--projection", "orthographic", "--view", "top", "--crop", "20,10,90,80",
       "--samples", "2"}};
  for (const int ranks : {2, 5}) {
    for (std::vector<std::string> look : looks) {
      if (ranks == 2 && look != looks[1]) continue;
      look.insert(look.end(), {"--size", "150x120", "--exr-type", "float", "--lattice", "ray"});
      const auto whole = drawn(0, "one", look);
      look.insert(look.end(), {"--distribute", "bricks"});
      const auto stats = drawn(ranks, "many", look);
      EXPECT_EQ(stats["shared_by"], "bricks");
      EXPECT_EQ(stats["bricks"]["total"], whole["bricks"]["total"]);
      EXPECT_GE(stats["bricks"]["interesting"], whole["bricks"]["interesting"]);
      EXPECT_LE(stats["bricks"]["interesting"], whole["bricks"]["total"]);
      const std::string name = look[1].substr(4);
      expectClose(name);
      EXPECT_EQ(readImageText(directory_ / "many" / name), readImageText(directory_ / "one" / name));
    }
  }
  // Each rank has only its part of the store, and the job's own volume is not there. In few bricks a part is the whole.
  EXPECT_EQ(runTool({"convert", "phantom:head:64x64x64", volume_, "--brick-size", "8", "--overwrite"}).exit_code, 0);
  const std::string parts = (directory_ / "part_#.kiln").string();
  const ToolResult split = runTool({"split", volume_, "-o", parts, "--parts", "3", "--tf", "ct-skin"});
  ASSERT_EQ(split.exit_code, 0) << split.err;
  EXPECT_LT(filesOf(directory_ / "part_1.kiln").size(), filesOf(volume_).size());
  const ToolResult half =
      runTool({"render", (directory_ / "part_1.kiln").string(), "-o", (directory_ / "h.png").string()});
  EXPECT_EQ(half.exit_code, 1);
  EXPECT_NE(half.err.find("the store is a part that kiln split made"), std::string::npos) << half.err;
  // A part holds what its camera is fitted to, and has the camera of the whole store.
  const auto cameraOf = [&](const std::string& store) {
    const std::string picture = (directory_ / "camera.exr").string();
    const ToolResult drawn =
        runTool({"render", store, "-o", picture, "--part", "1/3", "--tf", "ct-skin", "--size", "40x30"});
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    return nlohmann::json::parse(readImageText(picture).at("kiln:job")).at("camera");
  };
  EXPECT_EQ(cameraOf((directory_ / "part_1.kiln").string()), cameraOf(volume_));
  EXPECT_NE(runTool({"info", (directory_ / "part_1.kiln").string()}).out.find("part         voxels 0,0,0 to "),
            std::string::npos);
  std::vector<std::string> look = looks[1];
  look.insert(look.end(), {"--size", "150x120", "--exr-type", "float", "--lattice", "ray"});
  drawn(0, "one", look);
  fs::rename(volume_, directory_ / "away.kiln");
  look.insert(look.end(), {"--distribute", "bricks", "--store-local", parts});
  drawn(3, "many", look);
  expectClose("b.exr");
  // Colours are those of the named volume, of which each rank reads the whole.
  const std::string colors = (directory_ / "colors.kiln").string();
  EXPECT_EQ(runTool({"convert", "phantom:brain:32x32x32", colors}).exit_code, 0);
  look.insert(look.end(), {"--color-by", colors + ":fire"});
  drawn(3, "many", look);
  fs::rename(directory_ / "away.kiln", volume_);
  std::vector<std::string> alone = looks[1];
  alone.insert(alone.end(),
               {"--size", "150x120", "--exr-type", "float", "--lattice", "ray", "--color-by", colors + ":fire"});
  drawn(0, "one", alone);
  expectClose("b.exr");
  const ToolResult itself = run(3, {"render", volume_, "-o", (directory_ / "x.exr").string(), "--color-by", volume_,
                                    "--distribute", "bricks", "--store-local", parts});
  EXPECT_EQ(itself.exit_code, 2);
  EXPECT_NE(itself.err.find("leave out --store-local"), std::string::npos) << itself.err;
  const ToolResult fewer = run(2, {"render", volume_, "-o", (directory_ / "x.exr").string(), "--lattice", "ray",
                                   "--distribute", "bricks", "--store-local", parts});
  EXPECT_EQ(fewer.exit_code, 2);
  EXPECT_NE(fewer.err.find("run as many ranks as kiln split made parts"), std::string::npos) << fewer.err;
  const fs::path other =
      makeStore(head({{20, 20, 20}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8)), "ranks_other", 8);
  const ToolResult foreign = run(3, {"render", other.string(), "-o", (directory_ / "x.exr").string(), "--lattice",
                                     "ray", "--distribute", "bricks", "--store-local", parts});
  EXPECT_EQ(foreign.exit_code, 2);
  EXPECT_NE(foreign.err.find("holds a part of another store than " + other.string()), std::string::npos) << foreign.err;
}

// An unreadable brick fails exactly the frames that need the brick, whichever rank reads it.
TEST_F(RanksRender, AFrameThatFailsCostsNoOther) {
  const fs::path brick = fs::path(volume_) / "bricks/0/2_2_2.vdb";
  ASSERT_TRUE(fs::exists(brick));
  fs::resize_file(brick, fs::file_size(brick) - 1);
  const auto failing = [&](const std::string& name, const std::string& shared_by, const std::string& turn) {
    // A camera that fits what is visible reads the brick, too.
    return run(2, {"render", volume_, "-o", (directory_ / name).string(), "--size", "140x130", "--turntable", turn,
                   "--distribute", shared_by, "--threads", "1", "--fit", "box"});
  };
  for (const char* shared_by : {"tiles", "frames"}) {
    const ToolResult result = failing("f_##.png", shared_by, "4");
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_NE(result.err.find("failed; the first: rank "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("2_2_2.vdb"), std::string::npos) << result.err;
  }
  const ToolResult one = failing("f.png", "tiles", "1");
  EXPECT_EQ(one.exit_code, 1);
  EXPECT_NE(one.err.find(" of 2: frame 1: "), std::string::npos) << one.err;
  EXPECT_FALSE(fs::exists(directory_ / "f.png"));
}

// The name of the first frame is a folder's. Known because a single process draws all further frames, too.
TEST_F(RanksRender, AFrameWithoutAPlaceCostsNoOther) {
  for (const char* shared_by : {"tiles", "frames", "bricks"}) {
    const fs::path folder = directory_ / shared_by;
    fs::create_directories(folder / "f_1.png");
    const ToolResult result = run(2, {"render", volume_, "-o", (folder / "f_#.png").string(), "--size", "70x60",
                                      "--turntable", "3", "--samples", "1", "--lattice", "ray", "--distribute",
                                      shared_by, "--threads", "1", "--stats", (folder / "s.json").string()});
    EXPECT_EQ(result.exit_code, 1) << shared_by;
    EXPECT_NE(result.err.find("1 frame (1) failed; the first: rank "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("f_1.png: is a directory; name a file"), std::string::npos) << result.err;
    EXPECT_TRUE(fs::exists(folder / "f_2.png")) << result.err;
    EXPECT_TRUE(fs::exists(folder / "f_3.png")) << result.err;
    if (std::string(shared_by) != "bricks") continue;
    // A part of each of the two frames with a place.
    for (const auto& rank : nlohmann::json::parse(readTextFile(folder / "s.json"))["ranks"])
      EXPECT_EQ(rank["tiles"], 2) << rank;
  }
}

// The sentence about the rank is mpirun's own.
TEST_F(RanksRender, ARankThatIsKilledEndsTheJobAndResumeCompletesIt) {
  const std::vector<std::string> look = {"-o",          "OUT/t_##.exr", "--size", "240x240",
                                         "--turntable", "12",           "--tf",   "ct-skin"};
  drawn(0, "one", look);
  ToolOptions options;
  options.ranks = 3;
  options.seconds = 60;
  bool killed = false;
  options.interrupt_when = [&] {
    if (!killed && fs::exists(directory_ / "many/t_02.exr"))
      killed = signalOneRank((directory_ / "many").string(), SIGKILL);
    return false;
  };
  const ToolResult result = runTool({"render", volume_, "--threads", "1", "-o", (directory_ / "many/t_##.exr").string(),
                                     "--size", "240x240", "--turntable", "12", "--tf", "ct-skin"},
                                    options);
  EXPECT_FALSE(result.timed_out);
  if (killed && result.exit_code != 0) {
    EXPECT_NE(result.err.find("exited on signal 9"), std::string::npos) << result.err;
  }
  std::vector<std::string> resumed = look;
  resumed.emplace_back("--resume");
  drawn(2, "many", resumed);
  auto files = filesOf(directory_ / "many");
  std::erase_if(files, [](const auto& file) { return file.first.ends_with(".tmp"); });
  EXPECT_TRUE(files == filesOf(directory_ / "one"));
}

// A rank has another volume under the same name, as on a local disk. Known because its pictures differ.
TEST_F(RanksRender, ARankWithAnotherVolumeIsRefused) {
  for (const char* folder : {"zero", "other"}) fs::create_directories(directory_ / folder);
  fs::copy(volume_, directory_ / "zero/h.kiln", fs::copy_options::recursive);
  ASSERT_EQ(runTool({"convert", "phantom:head:48x48x48", (directory_ / "other/h.kiln").string()}).exit_code, 0);
  for (const char* shared_by : {"tiles", "frames", "bricks"}) {
    const std::vector<std::string> render = {
        "render",       "h.kiln", "-o",          (directory_ / "many/t_#.exr").string(),
        "--size",       "40x40",  "--turntable", "2",
        "--samples",    "1",      "--tf",        "ct-skin",
        "--distribute", shared_by};
    const ToolResult result = inFolders("zero", render, "other", render);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_NE(result.err.find("rank 1 on "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("the store h.kiln is another volume, with checksum "), std::string::npos) << result.err;
    EXPECT_TRUE(fs::is_empty(directory_ / "many")) << shared_by;
  }
  // A time series that differs only in its second frame.
  for (const char* folder : {"zero", "other"}) {
    for (const char* name : {"s_1.kiln", "s_2.kiln"})
      fs::copy(directory_ / "zero/h.kiln", directory_ / folder / name, fs::copy_options::recursive);
  }
  fs::remove_all(directory_ / "other/s_2.kiln");
  fs::copy(directory_ / "other/h.kiln", directory_ / "other/s_2.kiln", fs::copy_options::recursive);
  const std::vector<std::string> series = {"render", "s_#.kiln", "-o",       (directory_ / "many/s_#.exr").string(),
                                           "--size", "40x40",    "--frames", "1-2"};
  const ToolResult result = inFolders("zero", series, "other", series);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("the store s_2.kiln is another volume"), std::string::npos) << result.err;
  EXPECT_TRUE(fs::is_empty(directory_ / "many"));
}

TEST_F(RanksRender, ARankWithAnotherCommandOrJobIsRefused) {
  const std::string picture = (directory_ / "many/a.png").string();
  const std::vector<std::string> render = {"render", volume_, "-o", picture, "--size", "40x40"};
  const auto expectRefused = [&](const std::vector<std::string>& other, const std::string& mention) {
    const ToolResult result = inFolders("one", render, "one", other);
    EXPECT_EQ(result.exit_code, 1) << mention;
    EXPECT_NE(result.err.find("kiln: rank 0 of 2: rank 1 on "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(mention), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(picture)) << mention;
  };
  expectRefused({"render", volume_, "-o", picture, "--size", "40x41"}, "--size is 40x41 there and 40x40 here");
  expectRefused({"render", volume_, "-o", picture, "--size", "40x40", "--dry-run"}, "--dry-run is ");
  expectRefused({"info", volume_}, "the command is info there and render here");
  expectRefused({"render", volume_, "--sideways"}, "--sideways there and not given here");
  // A single job name with two contents.
  for (const auto& [folder, ambient] : {std::pair{"zero", "0.2"}, std::pair{"other", "0.4"}}) {
    fs::create_directories(directory_ / folder);
    FileSystem::real().writeAtomic(directory_ / folder / "job.json",
                                   R"({"kiln": 1, "volume": ")" + volume_ + R"(", "output": ")" + picture +
                                       R"(", "image": {"width": 40, "height": 40}, "shading": {"ambient": )" + ambient +
                                       "}}");
  }
  // A single name of a function of colours with two contents.
  for (const auto& [folder, color] : {std::pair{"zero", "0, 0, 1"}, std::pair{"other", "0, 1, 0"}})
    writeText(directory_ / folder / "colors.json", std::string(R"({"points": [{"value": 0, "opacity": 0, "color": [)") +
                                                       color +
                                                       R"(]}, {"value": 200, "opacity": 1, "color": [1, 1, 1]}]})");
  const std::vector<std::string> colored = {"render", volume_, "-o",         picture,
                                            "--size", "40x40", "--color-by", volume_ + ":colors.json"};
  const ToolResult colors = inFolders("zero", colored, "other", colored);
  EXPECT_EQ(colors.exit_code, 1);
  EXPECT_NE(colors.err.find("colorBy"), std::string::npos) << colors.err;
  EXPECT_FALSE(fs::exists(picture));
  const ToolResult result = inFolders("zero", {"render", "job.json"}, "other", {"render", "job.json"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("shading.ambient is 0.4 there and 0.2 here"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(picture));
}

// A stopped rank does not answer; without a watch all other ranks would wait forever.
TEST_F(RanksRender, ARankThatIsStoppedEndsTheJobAndIsNamed) {
  ToolOptions options;
  options.ranks = 2;
  options.seconds = 60;
  bool stopped = false;
  options.interrupt_when = [&] {
    if (!stopped && fs::exists(directory_ / "many/t_001.png"))
      stopped = signalOneRank((directory_ / "many").string(), SIGSTOP);
    return false;
  };
  const ToolResult result =
      runTool({"render", volume_, "--threads", "1", "-o", (directory_ / "many/t_###.png").string(), "--size", "200x200",
               "--turntable", "999", "--rank-timeout", "2"},
              options);
  ASSERT_TRUE(stopped);
  EXPECT_FALSE(result.timed_out);
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find(" s; it is stopped, or its machine or network is gone; --rank-timeout 2 ends"),
            std::string::npos)
      << result.err;
  // A rank continued and interrupted by mpirun prints nothing.
  EXPECT_EQ(result.err.find("interrupted"), std::string::npos) << result.err;
}

// All ranks start together, in a call of MPI that waits for the stopped rank. A rank that got further has its own
// watch.
TEST_F(RanksRender, ARankThatIsStoppedWhileMpiStartsEndsTheJob) {
  ToolOptions options;
  options.ranks = 2;
  options.seconds = 60;
  bool stopped = false;
  options.interrupt_when = [&] {
    if (!stopped) stopped = signalOneRank((directory_ / "many").string(), SIGSTOP);
    return false;
  };
  const ToolResult result =
      runTool({"render", volume_, "-o", (directory_ / "many/t.png").string(), "--size", "64x64", "--rank-timeout", "2"},
              options);
  ASSERT_TRUE(stopped);
  EXPECT_FALSE(result.timed_out);
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find("or its machine or network is gone; --rank-timeout 2 ends the run"), std::string::npos)
      << result.err;
}

}  // namespace
}  // namespace kiln::test
