// Outputs that are files which the command reads, by whatever name: refused, and no byte of them changed.
#include <gtest/gtest.h>

#include <filesystem>

#include "base/file.h"
#include "support/foreign_files.h"
#include "support/procedural.h"
#include "support/text_of.h"
#include "support/tiff_files.h"
#include "support/tool_test.h"

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
    writeText(in("job.json"), R"({"volume": "v.kiln", "transferFunction": "tf.json"})");
    done({"render", in("v.kiln"), "-o", in("p.png"), "--size", "16x16"});
    fs::create_directories(in("slices"));
    const ForeignVolume slices = randomVolume({32, 32, 3}, VoxelType::u8, 1);
    for (int z = 0; z < 3; ++z) writeTiff(in("slices/s" + std::to_string(z) + ".tif"), slices, z, z + 1);
  }

  // Each command with the output `found`, which leads to `read`.
  void expectRefused(const std::vector<std::string>& command, const std::string& read) {
    const std::vector<std::byte> before = readFile(in(read));
    refused(command, 2, "which this command reads");
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
    expectRefused(rendering("v.kiln", {option, in("link.json")}), "v.kiln/manifest.json");
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
  // A file that is only beside what is read may be written.
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
  expectRefused({"export", in("v.kiln"), in(brick), "--overwrite"}, brick);
  expectRefused({"export", in("v.kiln"), in("brick.vdb"), "--overwrite"}, brick);
  expectRefused({"tf", in("tf.json"), "-o", in("function.png")}, "tf.json");
  expectRefused({"tf", in("v.kiln"), "--tf", in("tf.json"), "-o", in("function.png")}, "tf.json");
  expectRefused({"tf", in("v.kiln"), "-o", in("brick.png")}, brick);
  done({"render", in("v.kiln"), "-o", in("part.exr"), "--size", "16x16", "--part", "1/1"});
  fs::create_symlink(in("part.exr"), in("whole.exr"));
  expectRefused({"composite", in("part.exr"), "-o", in("whole.exr")}, "part.exr");
}

}  // namespace
}  // namespace kiln::test
