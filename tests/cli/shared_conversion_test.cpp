// A conversion under mpirun. Known because a single process makes an equal store;
// tests/convert/shared_conversion_property_test.cpp covers ranks without processes. Skipped if Kiln is built without
// MPI or mpirun is not installed.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>

#include "support/system/run_tool.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Returns the process of a rank of the job that writes to `out`, 0 if there is none.
pid_t processOf(int rank, const fs::path& out) {
  const auto text_of = [](const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string variable = "\nOMPI_COMM_WORLD_RANK=" + std::to_string(rank) + "\n";
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator("/proc", gone)) {
    const std::string name = entry.path().filename().string();
    pid_t pid = 0;
    if (std::from_chars(name.data(), name.data() + name.size(), pid).ptr != name.data() + name.size()) continue;
    if (text_of(entry.path() / "cmdline").find(out.string()) == std::string::npos) continue;
    std::string environment = text_of(entry.path() / "environ");
    environment.insert(environment.begin(), '\n');
    std::replace(environment.begin(), environment.end(), '\0', '\n');
    if (environment.find(variable) != std::string::npos) return pid;
  }
  return 0;
}

class RanksConvert : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!canRunRanks()) GTEST_SKIP() << "Kiln is built without MPI, or mpirun is not there";
  }
  static std::vector<std::string> convertTo(const fs::path& out) {
    return {"convert", "phantom:head:90x80x70", out.string(), "--brick-size", "16"};
  }
};

// Returns all files except the manifest, which contains the command and its time.
std::map<std::string, std::vector<std::byte>> bricksOf(const fs::path& store) {
  std::map<std::string, std::vector<std::byte>> out = filesOf(store);
  EXPECT_EQ(out.erase("manifest.json"), 1u);
  return out;
}

TEST_F(RanksConvert, HasTheBytesOfOneProcess) {
  const fs::path one = freshDirectory("ranks_one") / "volume.kiln", many = freshDirectory("ranks_many") / "volume.kiln";
  ASSERT_EQ(runTool(convertTo(one)).exit_code, 0);
  ToolOptions three;
  three.ranks = 3;
  const ToolResult made = runTool(convertTo(many), three);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(bricksOf(many), bricksOf(one));
  for (const char* line : {"rank 0: ", "rank 1: ", "rank 2: "}) EXPECT_NE(made.out.find(line), std::string::npos);
  std::vector<std::string> asking = convertTo(many);
  asking.push_back("--dry-run");
  EXPECT_NE(runTool(asking, three).out.find("\nranks        3, each with that memory\n"), std::string::npos);
}

TEST_F(RanksConvert, GoesOnAfterARankWasKilled) {
  const fs::path one = freshDirectory("ranks_one") / "volume.kiln";
  ASSERT_EQ(runTool(convertTo(one)).exit_code, 0);
  for (const bool goes_on_alone : {true, false}) {
    const fs::path out = freshDirectory("ranks_killed") / "volume.kiln";
    bool killed = false;
    ToolOptions three;
    three.ranks = 3;
    three.interrupt_when = [&] {
      std::error_code none;
      const auto begun = fs::directory_iterator(out / "bricks" / "0", none);
      if (killed || none || std::distance(begun, fs::directory_iterator()) < 10) return false;
      const pid_t victim = processOf(1, out);
      killed = victim != 0 && ::kill(victim, SIGKILL) == 0;
      return false;
    };
    const ToolResult ended = runTool(convertTo(out), three);
    ASSERT_TRUE(killed);
    EXPECT_NE(ended.exit_code, 0);
    EXPECT_FALSE(ended.timed_out);
    EXPECT_FALSE(ended.err.empty());
    EXPECT_EQ(runTool({"info", out.string()}).exit_code, 1) << "something is taken for a store";
    std::vector<std::string> again = convertTo(out);
    again.push_back("--resume");
    ToolOptions others;
    others.ranks = goes_on_alone ? 0 : 2;
    const ToolResult resumed = runTool(again, others);
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_EQ(bricksOf(out), bricksOf(one));
  }
}

}  // namespace
}  // namespace kiln::test
