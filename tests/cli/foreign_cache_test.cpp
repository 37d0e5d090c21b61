// The cached store beside a foreign file: ownership, creation, and files that never count as a cache. Known because a
// picture of the file equals a picture of a store converted by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <thread>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "support/files/foreign_files.h"
#include "support/files/tiff_files.h"
#include "support/reference/drawing.h"
#include "support/system/text_of.h"
#include "support/system/tool_test.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class ForeignCache : public ToolTest {
 protected:
  ForeignCache() : ToolTest("cache_") {}
  // A volume of 64^3 bytes.
  void write(const std::string& name, double step) const {
    writeText(in(name), textOf(ramp({{64, 64, 64}, VoxelType::u8}, 1, step).voxels));
  }
  std::vector<std::string> drawn(const std::string& volume, const std::string& picture) const {
    return {"render", in(volume), "-o",     in(picture), "--size", "32x32",
            "--tf",   "solid:90", "--dims", "64,64,64",  "--type", "u8"};
  }
};

// Another file is moved to the name and keeps its time, as when archives are unpacked: the store is younger.
TEST_F(ForeignCache, AnotherFileOfThatNameIsConvertedThoughItIsOlder) {
  write("v.raw", 3);
  done(drawn("v.raw", "first.png"));
  done(drawn("v.raw", "again.png"));
  EXPECT_EQ(readFile(in("again.png")), readFile(in("first.png")));
  write("other.raw", 1.5);
  fs::last_write_time(in("other.raw"), fs::file_time_type::clock::now() - std::chrono::hours(24 * 365));
  fs::rename(in("other.raw"), in("v.raw"));
  done(drawn("v.raw", "second.png"));
  fs::rename(in("v.raw"), in("w.raw"));
  done(drawn("w.raw", "expected.png"));
  // Files differ in the volume's name.
  const Image second = readImage(in("second.png"));
  EXPECT_TRUE(equalBits(second, readImage(in("expected.png"))));
  EXPECT_FALSE(equalBits(second, readImage(in("first.png"))));
}

// Copies of a file may have another time; the manual promises a new store.
TEST_F(ForeignCache, AFileOfEqualContentAndAnotherTime_IsConvertedAnew) {
  write("v.raw", 3);
  done(drawn("v.raw", "first.png"));
  EXPECT_EQ(done(drawn("v.raw", "again.png")).err.find("converting"), std::string::npos);
  fs::last_write_time(in("v.raw"), fs::last_write_time(in("v.raw")) - std::chrono::hours(1));
  EXPECT_NE(done(drawn("v.raw", "second.png")).err.find("converting"), std::string::npos);
  EXPECT_EQ(readFile(in("second.png")), readFile(in("first.png")));
}

// A program that keeps times, as rsync does, replaces the voxels by others of equal size and time.
TEST_F(ForeignCache, AFileOfEqualSizeAndTime_IsConvertedAnew) {
  write("v.raw", 3);
  done(drawn("v.raw", "first.png"));
  const fs::file_time_type time = fs::last_write_time(in("v.raw"));
  write("v.raw", 1.5);
  fs::last_write_time(in("v.raw"), time);
  EXPECT_NE(done(drawn("v.raw", "second.png")).err.find("converting"), std::string::npos);
  EXPECT_FALSE(equalBits(readImage(in("second.png")), readImage(in("first.png"))));
  // A pair of file and store copied with its times stays valid.
  fs::copy_file(in("v.raw"), in("w.raw"));
  fs::last_write_time(in("w.raw"), time);
  fs::rename(in("v.raw.kiln"), in("w.raw.kiln"));
  EXPECT_EQ(done(drawn("w.raw", "third.png")).err.find("converting"), std::string::npos);
}

// Known because a picture from the named folder equals a picture from the store beside an equal file.
TEST_F(ForeignCache, StoresGoToTheNamedFolder_OneForEachFile) {
  for (const char* folder : {"a", "b"}) fs::create_directory(in(folder));
  write("a/v.raw", 3);
  write("b/v.raw", 1.5);
  ToolOptions variable;
  variable.environment = {"KILN_STORE_DIR=" + in("by_variable")};
  const auto draw = [&](const char* volume, const char* picture, const std::string& store, const ToolOptions& options) {
    std::vector<std::string> arguments = drawn(volume, picture);
    if (!store.empty()) arguments.insert(arguments.end(), {"--store", store});
    return done(arguments, options);
  };
  const auto stores = [&](const char* folder) {
    std::set<std::string> out;
    if (!fs::exists(in(folder))) return out;
    for (const auto& entry : fs::directory_iterator(in(folder))) out.insert(entry.path().filename().string());
    return out;
  };
  draw("a/v.raw", "a.png", "", variable);
  draw("b/v.raw", "b.png", "", variable);
  EXPECT_EQ(stores("by_variable").size(), 2u);
  EXPECT_TRUE(stores("by_variable").begin()->starts_with("v.raw-")) << *stores("by_variable").begin();
  EXPECT_FALSE(fs::exists(in("a/v.raw.kiln")));
  EXPECT_FALSE(equalBits(readImage(in("a.png")), readImage(in("b.png"))));
  // The option wins over the variable.
  draw("a/v.raw", "c.png", in("new/by_option"), variable);
  EXPECT_EQ(stores("new/by_option").size(), 1u);
  draw("a/v.raw", "beside.png", "", {});
  EXPECT_TRUE(fs::exists(in("a/v.raw.kiln")));
  for (const char* same : {"a.png", "c.png"})
    EXPECT_TRUE(equalBits(readImage(in(same)), readImage(in("beside.png")))) << same;
  // A link and another spelling are the same file; a dry run finds its store; a changed file replaces it.
  fs::create_symlink(in("a"), in("link"));
  EXPECT_EQ(draw("link/../b/../a/v.raw", "c.png", in("new/by_option"), {}).err.find("converting"), std::string::npos);
  std::vector<std::string> dry = drawn("link/v.raw", "d.png");
  dry.insert(dry.end(), {"--store", in("new/by_option"), "--dry-run"});
  done(dry);
  write("a/v.raw", 1.5);
  draw("a/v.raw", "d.png", in("new/by_option"), {});
  EXPECT_EQ(stores("new/by_option").size(), 1u);
  EXPECT_TRUE(equalBits(readImage(in("d.png")), readImage(in("b.png"))));
}

// Known because a user sets the variable once for all commands, and the option applies to one of the two volumes.
TEST_F(ForeignCache, TheVariableMayBeSetBesideStores_AndTheOptionIfOneVolumeIsAFile) {
  write("v.raw", 3);
  done(drawn("v.raw", "p.png"));
  ToolOptions variable;
  variable.environment = {"KILN_STORE_DIR=" + in("by_variable")};
  done({"render", in("v.raw.kiln"), "-o", in("q.png"), "--size", "16x16"}, variable);
  for (const char* name : {"v.raw.kiln", "p.png"}) done({"info", in(name)}, variable);
  for (const std::string& name : {in("v.raw.kiln"), std::string("fire")}) done({"tf", name}, variable);
  EXPECT_FALSE(fs::exists(in("by_variable")));
  std::vector<std::string> mixed = drawn("v.raw", "r.png");
  mixed.insert(mixed.end(), {"--add", in("v.raw.kiln"), "--store", in("stores")});
  done(mixed);
  EXPECT_TRUE(fs::exists(in("stores")));
}

TEST_F(ForeignCache, AFolderThatCannotHoldTheStore_NamesOtherFolders) {
  write("v.raw", 3);
  std::vector<std::string> arguments = drawn("v.raw", "p.png");
  arguments.insert(arguments.end(), {"--store", in("v.raw/below_a_file")});
  refused(arguments, 1, "cannot be made here (making the directory: Not a directory); name another folder by --store");
  refused(arguments, 1, "KILN_STORE_DIR");
}

// As on a render farm: a single process converts, all others wait and use the store.
TEST_F(ForeignCache, ProcessesThatStartAtOnceMakeOneStore) {
  write("v.raw", 3);
  std::vector<ToolResult> results(4);
  std::vector<std::thread> processes;
  for (std::size_t i = 0; i < results.size(); ++i)
    processes.emplace_back([&, i] { results[i] = runTool(drawn("v.raw", "p" + std::to_string(i) + ".png")); });
  for (std::thread& process : processes) process.join();
  int conversions = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].exit_code, 0) << results[i].err;
    conversions += results[i].err.find("converting to the store") != std::string::npos ? 1 : 0;
    EXPECT_EQ(readFile(in("p" + std::to_string(i) + ".png")), readFile(in("p0.png")));
  }
  EXPECT_EQ(conversions, 1);
  EXPECT_FALSE(fs::exists(in("v.raw.kiln.lock")));
}

// Folders with names as in a store, or temporary names, but without manifest or journal.
TEST_F(ForeignCache, FoldersThatAreNoStoresAreNeitherReplacedNorResumed) {
  write("v.raw", 3);
  fs::create_directories(in("a"));
  writeText(in("a/notes.tmp"), "mine");
  fs::create_directories(in("b/bricks"));
  writeText(in("b/bricks/mine.txt"), "mine");
  for (const char* how : {"--overwrite", "--resume"}) {
    for (const auto& [folder, file] : {std::pair{"a", "a/notes.tmp"}, {"b", "b/bricks/mine.txt"}}) {
      refused({"convert", in("v.raw"), in(folder), "--dims", "64,64,64", "--type", "u8", how}, 1, "is not a store");
      EXPECT_EQ(readTextFile(in(file)), "mine") << how;
    }
  }
  // A folder with the name for a replaced store is kept, too.
  done({"convert", in("v.raw"), in("d"), "--dims", "64,64,64", "--type", "u8"});
  fs::create_directories(in("d.old/bricks"));
  writeText(in("d.old/bricks/mine.txt"), "mine");
  refused({"convert", in("v.raw"), in("d"), "--dims", "64,64,64", "--type", "u8", "--overwrite"}, 1, "is in the way");
  EXPECT_EQ(readTextFile(in("d.old/bricks/mine.txt")), "mine");
  // Files left by a kill before the journal exists belong to the conversion.
  fs::create_directories(in("c/bricks/0"));
  writeText(in("c/bricks/0/1_0_0.vdb.tmp"), "half");
  writeText(in("c/scratch_aB3x9Z.tmp"), "");
  done({"convert", in("v.raw"), in("c"), "--dims", "64,64,64", "--type", "u8", "--resume"});
  done({"verify", in("c")});
}

// A directory's time changes when a store is made inside.
TEST_F(ForeignCache, AConversionIntoItsOwnInputIsResumed) {
  const ForeignVolume volume = randomVolume({256, 256, 64}, VoxelType::u16, 3);
  fs::create_directory(in("scan"));
  for (int z = 0; z < 64; ++z) writeTiff(in("scan/s" + std::to_string(z) + ".tif"), volume, z, z + 1);
  const std::vector<std::string> convert = {"convert",   in("scan"), in("scan/out.kiln"), "--brick-size", "16",
                                            "--threads", "1"};
  ToolOptions options;
  options.interrupt_when = [&] { return fs::exists(in("scan/out.kiln/bricks/0/3_3_0.vdb")); };
  const ToolResult first = runTool(convert, options);
  ASSERT_TRUE(first.interrupted) << "finished before it could be stopped";
  std::vector<std::string> resumed = convert;
  resumed.push_back("--resume");
  done(resumed);
  done({"verify", in("scan/out.kiln")});
}

}  // namespace
}  // namespace kiln::test
