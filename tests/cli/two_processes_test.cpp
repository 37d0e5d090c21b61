// Two processes with a common output: each output is whole and equals one of the two requested outputs, and exit codes
// are true.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <random>
#include <thread>

#include "base/file/file.h"
#include "base/file/file_lock.h"
#include "store/store_reader.h"
#include "support/files/foreign_files.h"
#include "support/system/text_of.h"
#include "support/system/tool_test.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class TwoProcesses : public ToolTest {
 protected:
  TwoProcesses() : ToolTest("two_") {}

  void write(const std::string& name, std::uint64_t seed) const {
    writeText(in(name), textOf(noise({{64, 64, 48}, VoxelType::u8}, seed, {0, 255}).voxels));
  }
  std::vector<std::string> conversion(const std::string& input, const std::string& out) const {
    return {"convert", in(input),   in(out), "--dims",       "64,64,48", "--type",
            "u8",      "--threads", "1",     "--brick-size", "16",       "--overwrite"};
  }
  std::vector<std::string> slice(const std::string& store, const std::string& out) const {
    return {"slice", in(store), "-o", in(out), "--window", "128,256"};
  }
  Hash128 contentOf(const std::string& store) const { return StoreReader(in(store)).manifest().index_checksum; }

  // Runs both, the second so much later.
  static std::array<ToolResult, 2> both(const std::vector<std::string>& a, const std::vector<std::string>& b,
                                        std::chrono::milliseconds later) {
    std::array<ToolResult, 2> results;
    std::thread other([&] { results[0] = runTool(a); });
    std::this_thread::sleep_for(later);
    results[1] = runTool(b);
    other.join();
    return results;
  }

  // The pairs of conversions, with equal and different sources in turn.
  void convertInPairs(int pairs) {
    write("a.raw", 1);
    write("b.raw", 2);
    done(conversion("a.raw", "a.kiln"));
    done(conversion("b.raw", "b.kiln"));
    std::mt19937 random(7);
    int refusals = 0;
    for (int pair = 0; pair < pairs; ++pair) {
      const std::string second = pair % 2 == 0 ? "b" : "a";
      const auto results = both(conversion("a.raw", "out.kiln"), conversion(second + ".raw", "out.kiln"),
                                std::chrono::milliseconds(random() % 60));
      EXPECT_TRUE(results[0].exit_code == 0 || results[1].exit_code == 0) << results[0].err << results[1].err;
      for (const ToolResult& result : results) {
        if (result.exit_code == 0) continue;
        ++refusals;
        EXPECT_EQ(result.exit_code, 1);
        EXPECT_EQ(result.errorLines().size(), 1u) << result.err;
        EXPECT_NE(result.err.find("is being written by"), std::string::npos) << result.err;
      }
      done({"verify", in("out.kiln")});
      const Hash128 found = contentOf("out.kiln");
      EXPECT_TRUE((results[0].exit_code == 0 && found == contentOf("a.kiln")) ||
                  (results[1].exit_code == 0 && found == contentOf(second + ".kiln")))
          << "the store is of no conversion that succeeded";
      for (const char* left : {".partial", ".old", ".lock"}) EXPECT_FALSE(fs::exists(in("out.kiln") + left)) << left;
    }
    EXPECT_GT(refusals, 0) << "no two conversions met";
  }
};

TEST_F(TwoProcesses, ConvertToOneOutput_TheStoreIsOneOfTheirs) { convertInPairs(6); }

TEST_F(TwoProcesses, NightlyConvertToOneOutput_TheStoreIsOneOfTheirs) { convertInPairs(200); }

// Known because readers open either of two stores, and each store has pictures and files of its own.
TEST_F(TwoProcesses, ReadersOfAStoreThatIsReplaced_HaveOneOfBothOrSayIt) {
  for (const std::uint64_t seed : {1, 2}) {
    const std::string name = seed == 1 ? "a" : "b";
    write(name + ".raw", seed);
    done(conversion(name + ".raw", name + ".kiln"));
    done(slice(name + ".kiln", name + ".png"));
  }
  done(conversion("a.raw", "out.kiln"));
  std::atomic<bool> ended = false;
  std::thread writer([&] {
    for (int i = 0; !ended; ++i) done(conversion(i % 2 == 0 ? "b.raw" : "a.raw", "out.kiln"));
  });
  const auto isOneOf = [&](const std::string& found, const std::string& ending) {
    const auto bytes = readFile(in(found));
    return bytes == readFile(in("a" + ending)) || bytes == readFile(in("b" + ending));
  };
  for (int round = 0; round < 6; ++round) {
    for (const std::vector<std::string>& reading : std::vector<std::vector<std::string>>{
             slice("out.kiln", "out.png"),
             {"render", in("out.kiln"), "-o", in("r.png"), "--size", "48x48", "--skip-damaged"},
             {"verify", in("out.kiln")},
             {"info", in("out.kiln"), "--json"},
             {"export", in("out.kiln"), in("out.vdb"), "--overwrite"},
             {"split", in("out.kiln"), "-o", in("part_#.kiln"), "--parts", "1"}}) {
      const ToolResult result = runTool(reading);
      if (result.exit_code == 0) {
        EXPECT_EQ(result.err.find("drawn without"), std::string::npos) << result.err;
        if (reading[0] == "slice") {
          EXPECT_TRUE(isOneOf("out.png", ".png"));
        }
        if (reading[0] == "split") done({"verify", in("part_1.kiln")});
      } else {
        EXPECT_EQ(result.exit_code, 1) << reading[0];
        EXPECT_NE(result.err.find("out.kiln: the store was replaced"), std::string::npos) << reading[0] << result.err;
      }
      fs::remove_all(in("part_1.kiln"));
    }
  }
  ended = true;
  writer.join();
}

TEST_F(TwoProcesses, AnOutputThatIsLocked_IsRefusedAndTheHolderNamed) {
  write("a.raw", 1);
  done(conversion("a.raw", "out.kiln"));
  const Hash128 before = contentOf("out.kiln");
  {
    const FileLock held(lockOf(in("out.kiln")), [] { FAIL() << "nobody else has it"; });
    refused(conversion("a.raw", "out.kiln"), 1, "is being written by kiln process " + std::to_string(::getpid()));
  }
  EXPECT_EQ(contentOf("out.kiln"), before);
  EXPECT_FALSE(fs::exists(in("out.kiln.lock")));
}

TEST_F(TwoProcesses, SplitOfAKilledOne_IsBegunAnewAndGoesOn) {
  write("a.raw", 1);
  done(conversion("a.raw", "a.kiln"));
  const std::vector<std::string> split = {"split", in("a.kiln"), "-o", in("part_#.kiln"), "--parts", "2"};
  done(split);
  const auto whole = filesOf(in("part_2.kiln"));
  // State after a kill: the first part finished, the second unfinished, with a lock file that no process holds.
  fs::rename(in("part_2.kiln"), in("part_2.kiln.partial"));
  fs::remove(in("part_2.kiln.partial/manifest.json"));
  writeText(in("part_2.kiln.lock"), "kiln process 1 on elsewhere\n");
  const ToolResult again = done(split);
  EXPECT_NE(again.out.find("is there already"), std::string::npos) << again.out;
  EXPECT_EQ(filesOf(in("part_2.kiln")), whole);
  for (const char* left : {"part_2.kiln.partial", "part_2.kiln.lock"}) EXPECT_FALSE(fs::exists(in(left))) << left;
  // A part of another store does not count as finished.
  write("b.raw", 2);
  done(conversion("b.raw", "b.kiln"));
  refused({"split", in("b.kiln"), "-o", in("part_#.kiln"), "--parts", "2"}, 1, "is there already");
}

}  // namespace
}  // namespace kiln::test
