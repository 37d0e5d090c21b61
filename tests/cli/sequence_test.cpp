// Sequences as users see them: files of an interrupted job of many frames, messages for people and machines, and
// refusals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "job/frame_list.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

struct PathOf {
  explicit PathOf(const std::string& value) { ::setenv("PATH", value.c_str(), 1); }
  ~PathOf() { ::setenv("PATH", before.c_str(), 1); }
  std::string before = std::getenv("PATH");
};

class SequenceCli : public ToolTest {
 protected:
  SequenceCli() : ToolTest("sequence_") {}
  void SetUp() override { done({"convert", "phantom:head:40x40x40", in("h.kiln"), "--brick-size", "16"}); }

  // Writes job.json: a turn with a fade from skin to bone, a moving clip plane and a moving light.
  void writeTurn(int frames, const std::string& more = "") const {
    writeText(in("job.json"), fmt::format(R"({{ "kiln": 1, "volume": "h.kiln", // all that moves
      "output": "out/f_####.exr", {} "image": {{"width": 40, "height": 36}},
      "camera": {{"turntable": {{"frames": {}}}}},
      "transferFunction": {{"keyframes": [{{"frame": 1, "function": "ct-skin"}}, {{"frame": {}, "function": "ct-bone"}}]}},
      "clip": {{"keyframes": [{{"frame": 1, "planes": [{{"normal": [0, 0, 1], "offset": 200}}]}},
                              {{"frame": {}, "planes": [{{"normal": [0, 0, 1], "offset": 0}}]}}]}} }})",
                                          more, frames, frames, frames));
    fs::create_directories(in("out"));
  }

  // Returns a PATH with a substitute for ffmpeg that stores its arguments and input; it fails if the file "fail"
  // exists.
  std::string pathWithFfmpeg() const {
    fs::create_directories(in("bin"));
    writeText(in("bin/ffmpeg"), "#!/bin/sh\ncase \"$*\" in *ffmetadata*) exit 1;; esac\necho \"$@\" > " +
                                    in("arguments") + "\nfor last; do :; done\ncat > \"${last#file:}\"\nif [ -e " +
                                    in("fail") + " ]; then echo 'no such codec' >&2; exit 3; fi\n");
    fs::permissions(in("bin/ffmpeg"), fs::perms::owner_all);
    return in("bin") + ":" + std::getenv("PATH");
  }

  std::size_t picturesIn(const std::string& folder) const {
    return static_cast<std::size_t>(std::count_if(
        fs::directory_iterator(in(folder)), {}, [](const auto& entry) { return entry.path().extension() != ".tmp"; }));
  }

  static std::vector<Json> eventsIn(const std::string& text) {
    std::vector<Json> out;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) out.push_back(Json::parse(line));
    return out;
  }
};

// The transfer function is given, and the fitted camera follows from it.
TEST_F(SequenceCli, ResumedWithAnotherTransferFunction_namesItBeforeTheCamera) {
  const std::vector<std::string> draw = {"render", in("h.kiln"), "-o", in("r_#.png"), "--size",
                                         "20x18",  "--frames",   "1",  "--tf"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), draw.begin(), draw.end());
    return more;
  };
  done(with({"ct-skin"}));
  const std::string error = runTool(with({"ct-bone", "--resume"})).err;
  const std::size_t function = error.find("is a picture of another job: transferFunction.");
  EXPECT_NE(function, std::string::npos) << error;
  EXPECT_EQ(error.find("camera.eye["), std::string::npos) << error;
}

// Known because another job is never interrupted. A job that is killed twice (between frames, and with the files of a
// power cut) and resumed leaves equal files, to the bit.
TEST_F(SequenceCli, InterruptedAndResumedIsTheSame) {
  writeTurn(12, R"("outputs": [{"path": "out/p_####.png"}, {"path": "out/z_####.exr", "content": "depth"},
                               {"path": "out/n_####.exr", "content": "normal"}],)");
  done({"render", in("job.json"), "--threads", "1"});
  const auto whole = filesOf(directory_ / "out");
  EXPECT_EQ(whole.size(), 48u);
  fs::remove_all(in("out"));
  fs::create_directories(in("out"));
  for (const std::size_t enough : {4u, 20u}) {
    ToolOptions interrupt;
    interrupt.interrupt_when = [&] { return picturesIn("out") > enough; };
    const ToolResult result = runTool({"render", in("job.json"), "--resume"}, interrupt);
    if (result.exit_code == 0) continue;  // the job ended before the kill
    EXPECT_EQ(result.exit_code, 1) << result.err;
    EXPECT_NE(result.err.find("of 12 frames are there and stay; the same command with --resume goes on"),
              std::string::npos)
        << result.err;
  }
  // A power cut leaves a truncated file, an empty file and a temporary file.
  const std::string first = in("out/f_0001.exr");
  fs::resize_file(first, fs::file_size(first) - 100);
  writeText(in("out/z_0002.exr"), "");
  writeText(in("out/f_0003.exr.tmp"), "left over");
  const ToolResult result = done({"render", in("job.json"), "--resume"});
  EXPECT_NE(result.out.find(" 0 failed"), std::string::npos) << result.out;
  fs::remove(in("out/f_0003.exr.tmp"));
  EXPECT_TRUE(filesOf(directory_ / "out") == whole);
  EXPECT_NE(done({"render", in("job.json"), "--resume"}).out.find("0 drawn, 12 kept"), std::string::npos);
}

// Known because a frame of a sequence equals the picture of a still job with equal settings.
TEST_F(SequenceCli, AFrameIsTheStillPicture) {
  // A turntable fits all its frames, a still picture itself; --fit box fits the first frame.
  const std::vector<std::string> camera = {"--size", "40x40", "--view", "front", "--fit", "box"};
  const auto drawn = [&](const std::string& name, std::vector<std::string> options) {
    options.insert(options.begin(), {"render", in("h.kiln"), "-o", in(name)});
    options.insert(options.end(), camera.begin(), camera.end());
    return done(options);
  };
  drawn("t_##.exr", {"--turntable", "8", "--frames", "1-8x2", "--stats", in("s.json")});
  EXPECT_EQ(Json::parse(readTextFile(in("s.json")))["frames"].size(), 4u);
  writeText(in("still.json"), readImageText(in("t_03.exr")).at("kiln:job"));
  done({"render", in("still.json"), "-o", in("still.exr")});
  EXPECT_EQ(readImage(in("still.exr")).rgba, readImage(in("t_03.exr")).rgba);
  drawn("one.exr", {});
  EXPECT_TRUE(readFile(in("one.exr")) == readFile(in("t_01.exr")));
  const ToolResult again = drawn("one.exr", {"--resume"});
  EXPECT_EQ(again.out, in("one.exr") + ": kept; it is there and whole\n");
  done({"render", in("h.kiln"), "-o", in("d_##/p.png"), "--size", "9x9", "--turntable", "2"});
  EXPECT_TRUE(fs::exists(in("d_02/p.png")));
  // No brick is read twice: bricks stay in memory from frame to frame.
  const Json frames = Json::parse(readTextFile(in("s.json")))["frames"];
  EXPECT_EQ(frames[1]["frame"], 3);
  EXPECT_LE(frames[1]["bricks"]["read"].get<int>(), 3);
  EXPECT_GT(frames[3]["memory"]["peak_rss_bytes"].get<std::uint64_t>(), 0u);
}

// Known because an option and the job's key are equivalent, and because performance options change no bit of the
// picture (areas enlarged beyond the picture hide nothing wrongly).
TEST_F(SequenceCli, OptionsAreTheJobsKeys) {
  const auto drawn = [&](std::vector<std::string> options, const std::string& keys) {
    options.insert(options.begin(), {"render", in("h.kiln"), "-o", in("o.exr"), "--size", "24x20"});
    done(options);
    writeText(
        in("job.json"),
        R"({"kiln": 2, "volume": "h.kiln", "output": "j.exr", "image": {"width": 24, "height": 20}, )" + keys + "}");
    done({"render", in("job.json")});
    EXPECT_TRUE(readFile(in("o.exr")) == readFile(in("j.exr"))) << keys;
  };
  drawn({"--fov", "40", "--elevation", "25", "--view", "left"},
        R"("camera": {"fov": 40, "elevation": 25, "view": "left"})");
  drawn(
      {"--projection", "orthographic", "--height", "150", "--up", "0,1,1", "--eye", "-500,0,0", "--target", "0,0,0"},
      R"("camera": {"projection": "orthographic", "height": 150, "up": [0, 1, 1], "eye": [-500, 0, 0], "target": [0, 0, 0]})");
  drawn({"--visibility", "range-tree", "--projected-area", "sphere", "--test-nodes-only", "--tile", "128"},
        R"("tile": 64)");
  drawn({"--visibility", "quadtree", "--quadtree-epsilon", "65536"},
        R"("visibility": {"method": "quadtree", "epsilon": 65536})");
}

// Between two keys the regions of both are drawn: at most as many as a function may have.
TEST_F(SequenceCli, FadesOfTooManyRegions_areRefused) {
  const auto keys = [](int first, int second) {
    const auto function = [](int regions, int from) {
      std::string list;
      for (int i = 0; i < regions; ++i)
        list +=
            fmt::format(R"({}{{"values": [{}, {}], "gradients": [0, 5]}})", i > 0 ? ", " : "", from + i, from + i + 1);
      return fmt::format(R"({{"points": [{{"value": 0, "color": "red", "opacity": 0.5}}], "regions": [{}]}})", list);
    };
    return fmt::format(R"({{"kiln": 2, "volume": "h.kiln", "output": "r_#.png", "image": {{"width": 20, "height": 20}},
        "frames": "2", "transferFunction": {{"keyframes": [{{"frame": 1, "function": {}}}, {{"frame": 3, "function": {}}}]}}}})",
                       function(first, 0), function(second, 100));
  };
  writeText(in("few.json"), keys(40, 24));
  done({"render", in("few.json")});
  writeText(in("many.json"), keys(40, 25));
  refused({"render", in("many.json")}, 2, "at most 64 regions in two neighbouring keys");
}

TEST_F(SequenceCli, WhatIsNotThisJobsIsNotTouched) {
  writeTurn(3);
  done({"render", in("job.json")});
  const auto before = filesOf(directory_ / "out");
  refused({"render", in("job.json"), "--resume", "--ambient", "0.3"}, 1,
          "f_0001.exr: is a picture of another job: shading.ambient is 0.2 there and 0.3 here; name another output");
  refused({"render", in("job.json"), "--resume", "--exr-type", "float"}, 1, "kind of file");
  // A moved store is the same volume, so the move is no difference either.
  fs::create_directory_symlink(in("h.kiln"), in("moved.kiln"));
  refused({"render", in("moved.kiln"), "-o", in("out/f_####.exr"), "--frames", "1", "--resume"}, 1,
          "of another job: image.width is 40 there and 1024 here");
  fs::remove(in("moved.kiln"));
  EXPECT_TRUE(filesOf(directory_ / "out") == before);
  refused({"render", in("job.json"), "-o", in("one.png")}, 2, "write " + in("one_####.png"));
  refused({"render", in("job.json"), "-o", in("none/a_#.png")}, 1, "no such directory");
  refused({"render", in("h.kiln"), "-o", in("none/a.png")}, 1, in("none/a.png") + ": cannot be made");
  refused({"render", in("h.kiln"), "-o", in("none/a.png"), "--repeat", "2"}, 1, in("none/a.png"));
  refused({"render", in("h.kiln"), "-o", in("a.png"), "--stats", in("none/s.json")}, 1, in("none/s.json"));
  refused({"render", in("h.kiln"), "-o", "/proc/a.png"}, 1, "/proc/a.png: making a scratch file");
  refused({"render", in("job.json"), "--frames", "3-1"}, 2, "--frames: expected numbers");
  refused({"render", in("job.json"), "--repeat", "2"}, 2, "--repeat");
  refused({"render", in("h.kiln"), "-o", in("a.png"), "--turntable", "0"}, 2, "--turntable");
  refused({"render", in("h.kiln"), "-o", in("a.png"), "--progress", "loud"}, 2, "--progress");
}

// A time series with a volume for each frame; a missing volume fails only its own frame.
TEST_F(SequenceCli, AFailedFrameDoesNotLoseTheOthers) {
  for (const int frame : {1, 2, 4}) {
    const std::string spacing = std::to_string(30 + frame);
    done({"convert", fmt::format("phantom:head:{0}x{0}x{0}", spacing), in(fmt::format("t_{:04}.kiln", frame))});
  }
  writeText(in("job.json"), R"({"kiln": 2, "volume": "t_####.kiln", "output": "f_####.png", "frames": "1-4",
                                "image": {"width": 16, "height": 16}})");
  const ToolResult result = runTool({"render", in("job.json"), "--progress", "json", "--stats", in("s.json")});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("1 frame (3) failed; the first: "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("t_0003.kiln"), std::string::npos) << result.err;
  std::vector<std::string> names;
  for (const Json& event : eventsIn(result.out)) names.push_back(event["event"]);
  EXPECT_EQ(names, (std::vector<std::string>{"started", "frame_started", "frame_done", "frame_started", "frame_done",
                                             "frame_failed", "frame_started", "frame_done", "finished", "failed"}));
  const Json last_done = eventsIn(result.out)[7];
  EXPECT_EQ(last_done["frame"], 4);
  EXPECT_EQ(last_done["done"], 4);
  for (const char* number : {"seconds", "read_bytes", "peak_rss_bytes", "peak_cache_bytes", "seconds_left"})
    EXPECT_TRUE(last_done[number].is_number()) << number;
  EXPECT_EQ(Json::parse(readTextFile(in("s.json")))["failed"], Json::array({3}));
  EXPECT_TRUE(fs::exists(in("f_0004.png")));
  EXPECT_FALSE(fs::exists(in("f_0003.png")));
  done({"convert", "phantom:head:33x33x33", in("t_0003.kiln")});
  EXPECT_NE(done({"render", in("job.json"), "--resume"}).out.find("1 drawn, 3 kept, 0 failed"), std::string::npos);
}

// Known: no frame of the job can be drawn, so that "--resume draws what is missing" would be wrong.
TEST_F(SequenceCli, OptionsThatNoFrameCanKeep_areRefusedBeforeTheFirst) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--level", "9"}, in("h.kiln") + ": level: there is no level 9"},
      {{"--tile", "100"}, "--tile: expected a power of two from 64 on"}};
  for (const auto& [options, sentence] : cases) {
    for (std::vector<std::string> words :
         {std::vector<std::string>{"--turntable", "3", "-o", in("p_#.png")}, std::vector<std::string>{"--dry-run"}}) {
      words.insert(words.begin(), {"render", in("h.kiln"), "--size", "16x16"});
      words.insert(words.end(), options.begin(), options.end());
      refused(words, 2, "kiln: " + sentence);
    }
  }
}

// A substitute for ffmpeg that stores its arguments and input.
TEST_F(SequenceCli, AVideoIsHandedToFfmpeg) {
  const std::string path = pathWithFfmpeg();
  writeTurn(3);
  {
    const PathOf none(in("out"));
    refused({"render", in("job.json"), "-o", in("v.mp4")}, 1, "v.mp4: a video needs the program ffmpeg");
  }
  const PathOf stand_in(path);
  writeText(in("fail"), "");
  refused({"render", in("job.json"), "-o", in("v.mp4"), "--rate", "12.5"}, 1, "failed with exit code 3: no such codec");
  EXPECT_FALSE(fs::exists(in("v.mp4")));
  fs::remove(in("fail"));
  EXPECT_NE(done({"render", in("job.json"), "-o", in("v.mp4"), "--rate", "12.5", "--resume"}).out.find("3 kept"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(in("v.mp4.frames")));
  EXPECT_NE(readTextFile(in("arguments")).find("-pix_fmt rgb24 -s 40x36 -r 25/2 -i - -an"), std::string::npos);
  const std::vector<std::byte> video = readFile(in("v.mp4"));
  ASSERT_EQ(video.size(), 3u * 40 * 36 * 3);
  // A job that also writes pictures encodes the frames of these pictures.
  writeTurn(3, R"("outputs": [{"path": "w_#.png"}], "video": {"rate": 12.5},)");
  done({"render", in("job.json"), "--resume"});
  writeText(in("job2.json"),
            R"({"kiln": 2, "volume": "h.kiln", "output": "w.webm", "outputs": [{"path": "w_#.png"}],)" +
                readTextFile(in("job.json")).substr(readTextFile(in("job.json")).find("\"image\"")));
  const ToolResult again = done({"render", in("job2.json"), "--resume"});
  EXPECT_NE(again.out.find("3 kept"), std::string::npos) << again.out << again.err;
  EXPECT_TRUE(readFile(in("w.webm")) == video);
}

// Known: a folder's name has no place for an eye, and a video is one file. The substitute's video is its frames' bytes.
TEST_F(SequenceCli, PlacesOfEyes_areInNamesOfPicturesAlone) {
  const PathOf stand_in(pathWithFfmpeg());
  fs::create_directory(in("50%volume"));
  const std::vector<std::string> turn = {"render", in("h.kiln"), "--turntable", "2", "--size", "16x16"};
  const std::vector<std::string> both = {"--stereo", "both", "--interocular", "20"};
  const auto with = [&](const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> out = turn;
    out.insert(out.end(), more.begin(), more.end());
    out.insert(out.end(), {"-o", in(output)});
    return out;
  };
  done(with("50%volume/film.mp4", {}));
  EXPECT_EQ(fs::file_size(in("50%volume/film.mp4")), 2u * 16 * 16 * 3);
  done(with("50%volume/pair.mp4", both));
  EXPECT_EQ(fs::file_size(in("50%volume/pair.mp4")), 2u * 32 * 16 * 3);
  done(with("50%volume/s_#_%v.png", both));
  EXPECT_TRUE(fs::exists(in("50%volume/s_2_r.png")));
  refused(with("v_%V.mp4", both), 2, "v_%V.mp4: has a place for an eye's name, but a video is one file");
  refused(with("50%volume.mp4", {}), 2, "leave %V and %v out");
  refused(with("n_#_%v.png", {}), 2, "leave %V and %v out");
  refused(with("s_%V.png", {"--stereo", "left", "--interocular", "20", "--sheet", "2"}), 2,
          "--sheet: a sheet is one picture (found " + in("s_%V.png") + ", one for each eye)");
  EXPECT_FALSE(fs::exists(in("v_%V.mp4.frames")));
}

// A video has no transparency: annotations are those of a black background, and dark on the paper of a picture.
TEST_F(SequenceCli, AnnotationsOfAVideo_areThoseOfBlack) {
  const PathOf stand_in(pathWithFfmpeg());
  const auto videoOf = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"render", in("h.kiln"), "-o",          in("v.mp4"), "--turntable", "2",
                                      "--size", "160x120",    "--scale-bar", "--text",    "a line"};
    words.insert(words.end(), more.begin(), more.end());
    done(words);
    return readFile(in("v.mp4"));
  };
  // The ink of the bar is a line of white pixels in the last rows; a dark bar has only a rim of grey.
  const auto whiteOf = [](const std::vector<std::byte>& video) {
    const auto rows = std::span(video).subspan(100u * 160 * 3, 20u * 160 * 3);
    return std::ranges::count_if(rows, [](std::byte value) { return std::to_integer<int>(value) > 250; });
  };
  const auto expected = whiteOf(videoOf({"--background", "black"}));
  EXPECT_GT(expected, 50);
  EXPECT_NEAR(static_cast<double>(whiteOf(videoOf({}))), static_cast<double>(expected), 6);
}

// Known: the frames of both videos have the same options. The annotations of an EXR lie beside its colours.
TEST_F(SequenceCli, AnnotationsOfAVideo_areDrawnBesideFramesOfLight) {
  const PathOf stand_in(pathWithFfmpeg());
  const auto videoOf = [&](const std::string& name, const std::string& outputs) {
    writeText(in("job.json"), R"({"kiln": 2, "volume": "h.kiln", "output": ")" + name + R"(", "outputs": [)" + outputs +
                                  R"(], "image": {"width": 160, "height": 120, "background": "black"},
                     "annotations": {"scaleBar": true}, "camera": {"turntable": {"frames": 2}}})");
    done({"render", in("job.json")});
    EXPECT_FALSE(fs::exists(in(name + ".frames")));
    return readFile(in(name));
  };
  const std::vector<std::byte> alone = videoOf("a.mp4", "");
  EXPECT_TRUE(videoOf("b.mp4", R"({"path": "b_#.exr"})") == alone);
  EXPECT_TRUE(videoOf("c.mp4", R"({"path": "c_#.exr"}, {"path": "c_#.png"})") == alone);
}

// An empty or relative element of PATH means the working directory, in which others may have put a program.
TEST_F(SequenceCli, Ffmpeg_InTheWorkingDirectory_IsNotRun) {
  pathWithFfmpeg();
  writeTurn(2);
  const fs::path before = fs::current_path();
  for (const auto& [working_directory, path] :
       {std::pair{"bin", ""}, {"bin", ":"}, {"bin", "."}, {"bin", "::/nowhere"}, {"", "bin"}, {"", "./bin"}}) {
    fs::current_path(in(working_directory));
    const PathOf unsafe(path);
    const ToolResult result = runTool({"render", in("job.json"), "-o", in("v.mp4")});
    fs::current_path(before);
    EXPECT_EQ(result.exit_code, 1) << path;
    EXPECT_NE(result.err.find("v.mp4: a video needs the program ffmpeg, which is in no absolute folder of PATH"),
              std::string::npos)
        << result.err;
  }
  const PathOf safe("::" + in("bin") + ":/bin:/usr/bin");
  done({"render", in("job.json"), "-o", in("v.mp4")});
}

// The installed ffmpeg accepts the arguments and frames that the substitute above only stores.
TEST_F(SequenceCli, Video_ByTheInstalledFfmpeg_HasEveryFrame) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  for (const char* video : {"v.mp4", "v.webm"}) {
    done({"render", in("h.kiln"), "-o", in(video), "--turntable", "5", "--size", "40x36", "--rate", "12.5"});
    const std::string command =
        "ffprobe -v error -count_frames -select_streams v:0 -of csv=p=0 -show_entries "
        "stream=width,height,r_frame_rate,nb_read_frames '" +
        in(video) + "' > '" + in("probed") + "'";
    ASSERT_EQ(std::system(command.c_str()), 0) << video;
    EXPECT_EQ(readTextFile(in("probed")), "40,36,25/2,5\n") << video;
  }
}

// Known: a video of the same frames has nothing to add, and is kept. A truncated file is made anew; a video of other
// pictures or of another rate is another job's. Frames that an earlier run left are removed.
TEST_F(SequenceCli, Video_thatIsThere_isKeptByResume) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  for (const char* name : {"v.mp4", "v.mkv", "v.mov", "v.webm"}) {
    const std::string video = in(name);
    const auto words = [&](const std::string& size, const std::string& rate) {
      return std::vector<std::string>{"render", in("h.kiln"), "-o",     video, "--turntable", "3",
                                      "--size", size,         "--rate", rate,  "--resume"};
    };
    const auto drawn = [&](const std::string& size, const std::string& rate) { return done(words(size, rate)).out; };
    EXPECT_NE(drawn("40x36", "10").find("3 drawn, 0 kept"), std::string::npos) << name;
    const std::vector<std::byte> whole = readFile(video);
    const auto time = fs::last_write_time(video);
    fs::create_directory(video + ".frames");
    EXPECT_NE(drawn("40x36", "10").find("0 drawn, 3 kept"), std::string::npos) << name;
    EXPECT_EQ(fs::last_write_time(video), time) << name;
    EXPECT_FALSE(fs::exists(video + ".frames")) << name;
    fs::resize_file(video, whole.size() / 2);
    EXPECT_NE(drawn("40x36", "10").find("3 drawn, 0 kept"), std::string::npos) << name;
    EXPECT_TRUE(readFile(video) == whole) << name;
    refused(words("40x36", "20"), 1, "is a video of another job or of other frames; name another output, or remove");
    refused(words("36x40", "10"), 1, "is a video of another job or of other frames");
    EXPECT_TRUE(readFile(video) == whole) << name;
  }
}

// Known because NTSC's rates are 1000/1001 of whole rates; ffprobe reads the video's header.
TEST_F(SequenceCli, NtscRates_areExactInTheVideo) {
  if (std::system("ffmpeg -version > /dev/null 2>&1 && ffprobe -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "ffmpeg or ffprobe is not installed";
  const auto rateOf = [&](const std::string& video) {
    const std::string probe =
        "ffprobe -v error -show_entries stream=r_frame_rate -of csv=p=0 '" + in(video) + "' > '" + in("rate") + "'";
    EXPECT_EQ(std::system(probe.c_str()), 0);
    return readTextFile(in("rate"));
  };
  const std::pair<const char*, const char*> rates[] = {
      {"23.976", "24000/1001\n"}, {"24000/1001", "24000/1001\n"}, {"29.97", "30000/1001\n"}, {"25", "25/1\n"}};
  for (const auto& [given, exact] : rates) {
    EXPECT_NE(done({"render", in("h.kiln"), "-o", in("v.mp4"), "--turntable", "2", "--size", "16x16", "--rate", given})
                  .out.find("2 frames, "),
              std::string::npos);
    EXPECT_EQ(rateOf("v.mp4"), exact) << given;
    fs::remove(in("v.mp4"));
  }
  for (const char* rate : {"\"60000/1001\"", "59.94"}) {
    writeTurn(2, fmt::format(R"("video": {{"rate": {}}},)", rate));
    done({"render", in("job.json"), "-o", in("j.mp4")});
    EXPECT_EQ(rateOf("j.mp4"), "60000/1001\n") << rate;
    fs::remove(in("j.mp4"));
  }
  writeTurn(2, R"("video": {"rate": "24/0"},)");
  refused({"render", in("job.json"), "-o", in("j.mp4")}, 2, "video.rate: expected frames a second from 0.1 to 1000");
  refused({"render", in("h.kiln"), "-o", in("v.mp4"), "--turntable", "2", "--rate", "fast"}, 2,
          "--rate: expected frames a second from 0.1 to 1000, such as 25, 23.976, 29.97 or 24000/1001, found 'fast'");
}

// After an interrupt the program does not wait for an encoder that hangs.
TEST_F(SequenceCli, AnEncoderThatHangsCanBeInterrupted) {
  const std::string path = pathWithFfmpeg();
  writeText(in("bin/ffmpeg"), "#!/bin/sh\nexec sleep 1000\n");
  writeTurn(3);
  const PathOf stand_in(path);
  ToolOptions options;
  options.seconds = 60;
  options.interrupt_when = [&] { return fs::exists(in("v.mp4.frames/000003.png")); };
  const ToolResult stopped = runTool({"render", in("job.json"), "-o", in("v.mp4")}, options);
  EXPECT_FALSE(stopped.timed_out);
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_NE(stopped.err.find("interrupted"), std::string::npos) << stopped.err;
}

// Known because the job's own keyframes place the camera.
TEST_F(SequenceCli, OptionsDoNotMoveACameraThatHasKeyframes) {
  writeText(in("keys.json"),
            R"({"kiln": 2, "volume": "h.kiln", "output": "k_#.png", "image": {"width": 16, "height": 16}, "camera":
      {"keyframes": [{"frame": 1, "view": "front"}, {"frame": 2, "view": "left"}]}})");
  refused({"render", in("keys.json"), "--eye", "0,0,300"}, 2, "--eye: the job says by keyframes where the camera is");
  refused({"render", in("keys.json"), "--zoom", "2"}, 2, "--zoom: the job says by keyframes");
  done({"render", in("keys.json")});
  writeText(in("none.json"), R"({"kiln": 2, "volume": "h.kiln", "output": "k_#.png", "camera":
      {"keyframes": [{"frame": 1.5, "view": "front"}]}})");
  refused({"render", in("none.json")}, 2, "no whole frame is between the first keyframe and the last");
}

// An EXR stores a pair in two parts; a video stores the eyes side by side. Known because halfway between two keys the
// frame equals the still picture of the mean settings.
TEST_F(SequenceCli, EyesMoveApartAndAreBesideEachOtherInAVideo) {
  const PathOf stand_in(pathWithFfmpeg());
  const std::string image = R"("image": {"width": 40, "height": 36}, "stereo": {"eye": "both", )";
  writeText(in("pair.json"),
            R"({"kiln": 2, "volume": "h.kiln", "output": "p.mp4", "outputs": [{"path": "p_#.exr"}], )" + image +
                R"("keyframes": [{"frame": 1, "interocular": 10, "convergence": 200},
                                                  {"frame": 3, "interocular": 30, "convergence": 300}]}})");
  done({"render", in("pair.json")});
  EXPECT_NE(readTextFile(in("arguments")).find(" -s 80x36 "), std::string::npos) << readTextFile(in("arguments"));
  EXPECT_EQ(fs::file_size(in("p.mp4")), 3u * 80 * 36 * 3);
  EXPECT_FALSE(fs::exists(in("p.mp4.frames")));
  writeText(in("still.json"), R"({"kiln": 2, "volume": "h.kiln", "output": "s.exr", )" + image +
                                  R"("interocular": 20, "convergence": 250}})");
  done({"render", in("still.json")});
  EXPECT_TRUE(readFile(in("s.exr")) == readFile(in("p_2.exr")));
  EXPECT_FALSE(readFile(in("s.exr")) == readFile(in("p_1.exr")));
  done({"render", in("pair.json"), "-o", in("n_#.exr"), "--interocular", "20", "--convergence", "250"});
  EXPECT_TRUE(readFile(in("n_1.exr")) == readFile(in("s.exr"))) << "what an option names stands still";
  EXPECT_TRUE(readFile(in("n_3.exr")) == readFile(in("s.exr")));
  done({"render", in("pair.json"), "-o", in("n_#.exr"), "--convergence", "250"});
  EXPECT_TRUE(readFile(in("n_2.exr")) == readFile(in("s.exr"))) << "other distances are the keys'";
  EXPECT_FALSE(readFile(in("n_3.exr")) == readFile(in("s.exr")));
}

// The sheet's frames are the pictures of the sequence: below captions, in a grid of two by two. No frame has a file.
TEST_F(SequenceCli, Sheet_showsFramesAtEqualSteps) {
  const std::vector<std::string> turn = {"render",      in("h.kiln"), "--tf",       "ct-bone", "--size",       "48x40",
                                         "--turntable", "8",          "--exr-type", "float",   "--background", "navy"};
  const auto draw = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = turn;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return done(arguments);
  };
  const ToolResult result = draw({"-o", in("sheet.exr"), "--sheet", "4"});
  EXPECT_NE(result.out.find("4 frames (1,3,5,7)"), std::string::npos) << result.out;
  draw({"-o", in("f_#.exr"), "--frames", "1-7x2"});
  const Image sheet = readImage(in("sheet.exr"));
  constexpr int kGap = 8, kCaption = 16, kTop = 4;
  ASSERT_EQ(sheet.width, 2 * (48 + kGap) + kGap);
  ASSERT_EQ(sheet.height, 2 * (40 + kGap + kCaption) + kTop);
  for (int i = 0; i < 4; ++i) {
    const Image frame = readImage(in("f_" + std::to_string(1 + 2 * i) + ".exr"));
    const int x0 = kGap + i % 2 * (48 + kGap), y0 = kTop + kCaption + i / 2 * (40 + kGap + kCaption);
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 4 * 48; ++x) ASSERT_EQ(sheet.pixel(x0, y0 + y)[x], frame.pixel(0, y)[x]) << i << " " << y;
    }
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 2 + 4) << "a sheet has no frames' files";
  // The last frame of a path is shown. A preview has none of the job's planes.
  writeText(in("path.json"), R"({"kiln": 2, "volume": "h.kiln", "output": "p_#.exr",
    "image": {"width": 48, "height": 40, "aov": ["depth"]},
    "camera": {"keyframes": [{"frame": 1, "view": "front"}, {"frame": 10, "view": "left"}]}})");
  const ToolResult path = done({"render", in("path.json"), "-o", in("path.exr"), "--sheet", "4"});
  EXPECT_NE(path.out.find("4 frames (1,4,7,10)"), std::string::npos) << path.out;
  EXPECT_NE(path.err.find("the planes of image.aov are left out"), std::string::npos) << path.err;
  EXPECT_NE(done({"render", in("path.json"), "-o", in("path.png"), "--frames", "1"}).err.find("image.aov"),
            std::string::npos);
  refused({"render", in("path.json"), "-o", in("path.png"), "--frames", "1", "--aov", "depth"}, 2, "--aov");
  std::vector<std::string> still = {"render", in("h.kiln"), "-o", in("s.exr"), "--sheet", "4"};
  refused(still, 2, "--sheet: a sheet shows frames of a sequence (found 1)");
  still.insert(still.end(), {"--turntable", "8", "--resume"});
  refused(still, 2, "--sheet: a sheet is drawn at once");
  still.back() = "--deep";
  refused(still, 2, "--sheet: a sheet holds colours alone");
}

TEST_F(SequenceCli, Sheet_isTracedAndWarnsOfEmptyFrames) {
  std::vector<std::string> sheet = {"render", in("h.kiln"),    "-o",      in("s.png"),   "--size",
                                    "16x16",  "--sheet",       "2",       "--turntable", "4",
                                    "--tf",   "9000:0,9001:1", "--trace", in("t.json"),  "--strict"};
  const ToolResult empty = runTool(sheet);
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_NE(empty.err.find("empty"), std::string::npos) << empty.err;
  EXPECT_NE(readTextFile(in("t.json")).find("traceEvents"), std::string::npos);
  sheet[3] = in("s_##.png");
  refused(sheet, 2, "--sheet: a sheet is one picture");
}

// A picture's job draws the picture again, wherever picture and volume were moved together.
TEST_F(SequenceCli, Picture_isDrawnFromItsJobBesideItsVolume) {
  for (const std::string ending : {".exr", ".png"}) {
    SCOPED_TRACE(ending);
    fs::create_directories(in("a"));
    done({"render", in("h.kiln"), "-o", in("a/p" + ending), "--size", "40x36", "--tf", "ct-bone"});
    done({"render", in("a/p" + ending), "-o", in("again" + ending)});  // where it was
    EXPECT_EQ(readImage(in("again" + ending)).rgba, readImage(in("a/p" + ending)).rgba);
    fs::rename(in("h.kiln"), in("a/h.kiln"));
    fs::rename(in("a"), in("b"));
    done({"render", in("b/p" + ending), "-o", in("again" + ending)});  // beside the picture
    EXPECT_EQ(readImage(in("again" + ending)).rgba, readImage(in("b/p" + ending)).rgba);
    fs::rename(in("b/h.kiln"), in("h.kiln"));
    fs::rename(in("h.kiln"), in("moved.kiln"));
    const ToolResult lost = runTool({"render", in("b/p" + ending), "-o", in("lost" + ending)});
    EXPECT_EQ(lost.exit_code, 1);
    for (const std::string& place : {in("b/h.kiln"), in("h.kiln")})
      EXPECT_NE(lost.err.find(place), std::string::npos) << place << " is not in: " << lost.err;
    fs::rename(in("moved.kiln"), in("h.kiln"));
    fs::remove_all(in("b"));
  }
  done({"tf", "ct-bone", "-o", in("plot.png")});
  refused({"render", in("plot.png"), "-o", in("x.png")}, 2, "is a picture without a job of Kiln");
}

// The header leads from the picture's folder to the folder of the command: also in a tree that was moved as a whole,
// from any current folder, and through a link. No absolute path enters the header.
TEST_F(SequenceCli, PictureOfARelativeName_isDrawnFromWhereTheVolumeWas) {
  for (const std::string ending : {".exr", ".png"}) {
    SCOPED_TRACE(ending);
    fs::create_directories(in("tree/data"));
    fs::create_directories(in("tree/out/deep"));
    fs::copy(in("h.kiln"), in("tree/data/h.kiln"), fs::copy_options::recursive);
    const std::string name = "out/deep/p" + ending;
    ASSERT_EQ(runTool({"render", "data/h.kiln", "-o", name, "--size", "40x36"}, {.directory = in("tree")}).exit_code,
              0);
    const std::map<std::string, std::string> texts = readImageText(in("tree/" + name));
    EXPECT_EQ(texts.at("kiln:folder"), "../..");
    for (const auto& [key, text] : texts) EXPECT_EQ(text.find(in("tree")), std::string::npos) << key;
    fs::rename(in("tree"), in("moved"));
    fs::create_directory_symlink(in("moved/out/deep"), in("link"));
    for (const std::string& picture : {in("moved/" + name), in("link/p" + ending)}) {
      SCOPED_TRACE(picture);
      done({"render", picture, "-o", in("again" + ending)});
      EXPECT_EQ(readImage(in("again" + ending)).rgba, readImage(picture).rgba);
    }
    fs::remove_all(in("moved"));
    fs::remove(in("link"));
  }
}

// As above, for a composite in another folder than its parts.
TEST_F(SequenceCli, CompositeOfRelativeNames_isDrawnFromWhereTheVolumeWas) {
  fs::create_directories(in("tree/data"));
  fs::create_directories(in("tree/parts"));
  fs::create_directories(in("tree/out/deep"));
  fs::copy(in("h.kiln"), in("tree/data/h.kiln"), fs::copy_options::recursive);
  const auto run = [&](const std::string& folder, const std::vector<std::string>& words) {
    const ToolResult result = runTool(words, {.directory = in(folder)});
    ASSERT_EQ(result.exit_code, 0) << result.err;
  };
  const auto again = [&](const std::string& picture) {
    done({"render", in(picture), "-o", in("again.exr")});
    EXPECT_GT(compareImages(readImage(in("again.exr")), readImage(in(picture))).psnr_db, 50) << picture;
  };
  run("tree", {"render", "data/h.kiln", "-o", "parts/p.exr", "--size", "20x18", "--part", "1/1"});
  run("tree", {"composite", "parts/p.exr", "-o", "out/deep/whole.exr"});
  EXPECT_EQ(readImageText(in("tree/out/deep/whole.exr")).at("kiln:folder"), "../..");
  again("tree/out/deep/whole.exr");
  // The folder of the command is that of the part.
  run("tree/parts", {"render", "../data/h.kiln", "-o", "q.exr", "--size", "20x18", "--part", "1/1"});
  run("tree/parts", {"composite", "q.exr", "-o", "whole.exr"});
  run("tree/parts", {"composite", "q.exr", "-o", "../out/whole.exr"});
  EXPECT_FALSE(readImageText(in("tree/parts/whole.exr")).contains("kiln:folder"));
  again("tree/parts/whole.exr");
  again("tree/out/whole.exr");
  // The volume of colours may be the only relative name.
  run("tree/parts",
      {"render", in("h.kiln"), "--color-by", "../data/h.kiln", "-o", "m.exr", "--size", "20x18", "--part", "1/1"});
  run("tree/parts", {"composite", "m.exr", "-o", "../out/colored.exr"});
  EXPECT_EQ(readImageText(in("tree/out/colored.exr")).at("kiln:folder"), "../parts");
}

}  // namespace
}  // namespace kiln::test
