// A limit of addresses, from nothing after the start of the program to enough for the whole command: each run either
// gives the result of a run without a limit, or ends in one line on memory or threads. No file is called damaged,
// because none is.
#include <gtest/gtest.h>

#include <filesystem>

#include "base/file/file.h"
#include "support/system/sanitized.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class RefusedMemory : public ToolTest {
 protected:
  RefusedMemory() : ToolTest("refused_memory_") {}
  void SetUp() override {
    if (kSanitized) GTEST_SKIP() << "a sanitizer reserves terabytes of addresses";
    done({"convert", "phantom:head:90x90x90", in("h.kiln"), "--brick-size", "32"});
  }

  // Returns the file's bytes but for the random identity that OpenVDB writes into a grid file.
  std::vector<std::byte> written(const std::string& output) const {
    if (output.empty()) return {};
    std::vector<std::byte> out = readFile(in(output));
    constexpr int kIdentity = 21, kIdentityEnd = kIdentity + 36;
    if (output.ends_with(".vdb")) out.erase(out.begin() + kIdentity, out.begin() + kIdentityEnd);
    return out;
  }

  // Runs the command, which writes `output`, if that is not empty, under growing limits until it succeeds. The limits
  // are those of ToolOptions: of the whole process, or of what it adds after its start.
  void expectNoFileBlamed(const std::vector<std::string>& arguments, const std::string& output,
                          std::uint64_t ToolOptions::*limit = &ToolOptions::more_address_bytes) {
    const std::uint64_t least = limit == &ToolOptions::address_bytes ? 90 << 20 : 0, most = least + (170 << 20);
    constexpr std::uint64_t kStep = 2500 << 10;
    const ToolResult free = done(arguments);
    const std::vector<std::byte> expected = written(output);
    int failed = 0, done_in_a_row = 0;
    for (std::uint64_t bytes = least; bytes < most && done_in_a_row < 4; bytes += kStep) {
      if (!output.empty()) fs::remove(in(output));
      ToolOptions options;
      options.*limit = bytes;
      const ToolResult result = runTool(arguments, options);
      const std::string said = std::to_string(bytes >> 10) + " KiB: " + arguments[0] + ": " + result.err + result.out;
      if (result.exit_code == 127) continue;  // the system's loader has no room for the libraries
      if (result.exit_code == 0) {
        ++done_in_a_row;
        EXPECT_EQ(result.err, free.err) << said;
        EXPECT_TRUE(written(output) == expected) << said;
        continue;
      }
      ++failed;
      done_in_a_row = 0;
      EXPECT_EQ(result.exit_code, 1) << said;
      EXPECT_EQ(result.errorLines().size(), 1u) << said;
      EXPECT_NE(result.err.find("memory"), std::string::npos) << said;
      for (const char* blame : {"unexpected", "damaged", ".vdb: OpenVDB", "drawn without", "cannot be read"})
        EXPECT_EQ(said.find(blame), std::string::npos) << said;
    }
    EXPECT_GT(failed, 0);
    EXPECT_GT(done_in_a_row, 0);
  }
};

// Executes the program, whose libraries then meet the limit, too.
TEST_F(RefusedMemory, BlamesNoBrickInVerify) {
  expectNoFileBlamed({"verify", in("h.kiln"), "--threads", "2"}, "", &ToolOptions::address_bytes);
}

TEST_F(RefusedMemory, DrawsNoPictureWithoutABrick) {
  expectNoFileBlamed(
      {"render", in("h.kiln"), "-o", in("o.png"), "--size", "200x200", "--skip-damaged", "--threads", "2"}, "o.png");
}

TEST_F(RefusedMemory, EndsInOneLineInExport) {
  expectNoFileBlamed({"export", in("h.kiln"), in("o.vdb"), "--overwrite"}, "o.vdb");
}

TEST_F(RefusedMemory, EndsInOneLineInSliceAndConvert) {
  expectNoFileBlamed({"slice", in("h.kiln"), "-o", in("o.exr")}, "o.exr");
  done({"export", in("h.kiln"), in("h.vdb")});
  // One thread: OpenVDB reads grids with Blosc, which ends the process if its own allocation fails.
  expectNoFileBlamed({"convert", in("h.vdb"), in("c.kiln"), "--overwrite", "--threads", "1"}, "c.kiln/index.bin");
}

}  // namespace
}  // namespace kiln::test
