// Outputs that are also inputs of the command, under any name: refused, and no byte changed.
#include <gtest/gtest.h>

#include <filesystem>

#include "base/file/file.h"
#include "support/files/foreign_files.h"
#include "support/files/tiff_files.h"
#include "support/system/text_of.h"
#include "support/system/tool_test.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class OverwrittenInputs : public ToolTest {
 protected:
  OverwrittenInputs() : ToolTest("over_") {
    writeText(in("v.raw"), textOf(ramp({{32, 32, 32}, VoxelType::u8}, 1, 5).voxels));
    done({"convert", in("v.raw"), in("v.kiln"), "--dims", "32,32,32", "--type", "u8", "--brick-size", "16"});
    writeText(in("v.nhdr"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 32 32 32\nencoding: raw\ndata file: v.raw\n");
    writeText(in("tf.json"), R"({"points": [{"value": 0, "opacity": 0}, {"value": 255, "opacity": 0.5}]})");
    writeText(in("job.json"), R"({"kiln": 2, "volume": "v.kiln", "transferFunction": "tf.json"})");
    done({"render", in("v.kiln"), "-o", in("p.png"), "--size", "16x16"});
    fs::create_directories(in("slices"));
    const ForeignVolume slices = randomVolume({32, 32, 3}, VoxelType::u8, 1);
    for (int z = 0; z < 3; ++z) writeTiff(in("slices/s" + std::to_string(z) + ".tif"), slices, z, z + 1);
  }

  // Runs the command with an output `found` that is the input `read`.
  void expectRefused(const std::vector<std::string>& command, const std::string& read,
                     const std::string& mention = "which this command reads") {
    const std::vector<std::byte> before = readFile(in(read));
    refused(command, 2, mention);
    EXPECT_EQ(readFile(in(read)), before) << read;
  }
  std::vector<std::string> rendering(const std::string& input, const std::vector<std::string>& more) const {
    std::vector<std::string> out = {"render", in(input), "--size", "16x16", "-o", in("q.png")};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
};

TEST_F(OverwrittenInputs, OfRender_AreRefusedByAnyName) {
  fs::create_symlink(in("v.kiln/manifest.json"), in("link.json"));
  fs::create_hard_link(in("v.kiln/index.bin"), in("hard.json"));
  fs::create_hard_link(in("v.kiln/bricks/0/0_0_0.vdb"), in("brick.png"));
  fs::create_hard_link(in("slices/s1.tif"), in("slice.json"));
  for (const char* option : {"--stats", "--trace"}) {
    expectRefused(rendering("v.kiln", {option, in("link.json")}), "v.kiln/manifest.json",
                  "link.json would be in the store");
    expectRefused(rendering("v.kiln", {option, in("hard.json")}), "v.kiln/index.bin");
    expectRefused(rendering("job.json", {option, in("job.json")}), "job.json");
    expectRefused(rendering("job.json", {option, in("tf.json")}), "tf.json");
    expectRefused(rendering("v.kiln", {"--tf", in("tf.json"), option, in("tf.json")}), "tf.json");
    expectRefused(rendering("v.kiln", {"--add", in("v.nhdr"), option, in("v.raw")}), "v.raw");
    expectRefused(rendering("v.nhdr", {option, in("v.raw")}), "v.raw");
    expectRefused(rendering("slices", {option, in("slices/s0.tif")}), "slices/s0.tif");
    expectRefused(rendering("slices", {option, in("slice.json")}), "slices/s1.tif");
  }
  EXPECT_FALSE(fs::exists(in("slices.kiln"))) << "refused after a conversion";
  EXPECT_FALSE(fs::exists(in("v.nhdr.kiln"))) << "refused after a conversion";
  expectRefused({"render", in("v.kiln"), "--size", "16x16", "-o", in("brick.png")}, "v.kiln/bricks/0/0_0_0.vdb");
  // A file beside the inputs may be written.
  writeText(in("slices/notes.json"), "{}");
  done(rendering("slices", {"--stats", in("slices/notes.json")}));
}

TEST_F(OverwrittenInputs, OfOtherCommands_AreRefusedByAnyName) {
  fs::create_hard_link(in("p.png"), in("same.png"));
  fs::create_hard_link(in("v.kiln/bricks/0/0_0_0.vdb"), in("brick.vdb"));
  fs::create_hard_link(in("v.kiln/bricks/0/0_0_0.vdb"), in("brick.png"));
  fs::create_hard_link(in("tf.json"), in("function.png"));
  const std::string brick = "v.kiln/bricks/0/0_0_0.vdb";
  expectRefused({"compare", in("p.png"), in("p.png"), "-o", in("same.png")}, "p.png");
  expectRefused({"slice", in("v.kiln"), "-o", in("brick.png")}, brick);
  expectRefused({"export", in("v.kiln"), in(brick), "--overwrite"}, brick, "would be in the store");
  expectRefused({"export", in("v.kiln"), in("brick.vdb"), "--overwrite"}, brick);
  expectRefused({"tf", in("tf.json"), "-o", in("function.png")}, "tf.json");
  expectRefused({"tf", in("v.kiln"), "--tf", in("tf.json"), "-o", in("function.png")}, "tf.json");
  expectRefused({"tf", in("v.kiln"), "-o", in("brick.png")}, brick);
  done({"render", in("v.kiln"), "-o", in("part.exr"), "--size", "16x16", "--lattice", "ray", "--part", "1/1"});
  fs::create_symlink(in("part.exr"), in("whole.exr"));
  expectRefused({"composite", in("part.exr"), "-o", in("whole.exr")}, "part.exr");
}

TEST_F(OverwrittenInputs, OfBench_AreRefusedByAnyName) {
  fs::create_directories(in("report"));
  writeText(in("suite.json"),
            R"({"kiln_suite": 1, "cases": [{"name": "V", "volume": "v.kiln", "transferFunction": "tf.json"}]})");
  for (const char* file : {"suite.json", "tf.json"}) {
    fs::create_hard_link(in(file), in("report/report.json"));
    expectRefused({"bench", in("suite.json"), "-o", in("report"), "--quick"}, file);
    fs::remove(in("report/report.json"));
  }
}

// Names of a command's unfinished work are refused for its other outputs.
TEST_F(OverwrittenInputs, NamesOfUnfinishedWork_AreNoOutputs) {
  const std::string another = "is the name of another file of this command";
  for (const char* option : {"--stats", "--trace"}) {
    for (const char* name : {"z.png.tiles", "z.png.tiles.lock"})
      refused({"render", in("v.kiln"), "--size", "16x16", "-o", in("z.png"), "--checkpoint", option, in(name)}, 2,
              another);
    const std::vector<std::string> video = {"render", in("v.kiln"), "--turntable", "2", "-o", in("v.mp4"), "--dry-run"};
    const auto with = [&](const std::string& name) {
      std::vector<std::string> out = video;
      out.insert(out.end(), {option, in(name)});
      return out;
    };
    refused(with("v.mp4.lock"), 2, another);
    fs::create_directories(in("v.mp4.frames"));
    fs::create_directory_symlink(in("v.mp4.frames"), in("frames"));
    for (const char* name : {"v.mp4.frames", "v.mp4.frames/s.json", "frames/s.json"})
      refused(with(name), 2, "where the frames of the video are kept until it is made");
    fs::remove(in("frames"));
    fs::remove(in("v.mp4.frames"));
    refused(with("v.mp4.frames"), 2, "where the frames of the video are kept until it is made");
  }
  writeText(in("video.json"),
            R"({"kiln": 2, "volume": "v.kiln", "output": "v.mp4", "camera": {"turntable": {"frames": 2}},
                                  "outputs": [{"path": "v.mp4.frames/d_#.exr", "content": "depth"}]})");
  refused({"render", in("video.json"), "--dry-run"}, 2, "where the frames of the video are kept until it is made");
  EXPECT_FALSE(fs::exists(in("v.mp4.frames")));
}

TEST_F(OverwrittenInputs, NewFilesInAStore_AreRefusedByEveryCommand) {
  const auto names = [&] {
    std::vector<std::string> out;
    for (const auto& entry : fs::recursive_directory_iterator(in("v.kiln"))) out.push_back(entry.path().string());
    return out;
  };
  const std::vector<std::string> before = names();
  fs::create_directory_symlink(in("v.kiln"), in("folder"));
  fs::create_symlink(in("v.kiln/new.png"), in("new.png"));
  done({"render", in("v.kiln"), "-o", in("part.exr"), "--size", "16x16", "--part", "1/1"});
  writeText(in("suite.json"), R"({"kiln_suite": 1, "cases": [{"name": "V", "volume": "v.kiln"}]})");
  const std::string mention = "would be in the store";
  for (const char* place : {"v.kiln", "v.kiln/bricks/0", "folder", "v.kiln/../folder/bricks"}) {
    const std::string to = in(place) + "/new";
    refused(rendering("v.kiln", {"--stats", to + ".json"}), 2, mention);
    refused(rendering("v.kiln", {"--trace", to + ".json"}), 2, mention);
    refused({"render", in("p.kiln"), "-o", to + ".png"}, 2, mention);
    refused({"render", in("v.kiln"), "--turntable", "2", "-o", to + "_#.png"}, 2, mention);
    refused({"slice", in("v.kiln"), "-o", to + ".png"}, 2, mention);
    refused({"tf", "ct-bone", "-o", to + ".png"}, 2, mention);
    refused({"compare", in("p.png"), in("p.png"), "-o", to + ".png"}, 2, mention);
    refused({"composite", in("part.exr"), "-o", to + ".exr"}, 2, mention);
    refused({"export", in("v.kiln"), to + ".vdb"}, 2, mention);
    refused({"split", in("v.kiln"), "-o", to + "_#.kiln", "--parts", "2"}, 2, mention);
    refused({"convert", in("v.nhdr"), to + ".kiln"}, 2, mention);
    refused({"convert", in("v.nhdr"), to + "/deeper/new.kiln/"}, 2, mention);
    refused({"bench", in("suite.json"), "-o", to}, 2, mention);
    refused({"manual", in(place)}, 2, mention);
  }
  refused({"slice", in("v.kiln"), "-o", in("new.png")}, 2, mention);
  EXPECT_EQ(names(), before);
  // A folder with a file of such a name is no store.
  fs::create_directories(in("notes"));
  writeText(in("notes/manifest.json"), "{}");
  done(rendering("v.kiln", {"--stats", in("notes/s.json")}));
}

}  // namespace
}  // namespace kiln::test
