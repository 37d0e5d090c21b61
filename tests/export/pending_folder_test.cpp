// Known: where a disk cannot exchange two names, the folder that is replaced is there until the new one has its name.
#include "export/output/pending_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/file/same_file.h"
#include "support/system/expect_error.h"
#include "support/system/snapshot_disk.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Cannot exchange names; a chosen rename fails, not counting that of the folder's description.
class PlainDisk : public FileSystem {
 public:
  explicit PlainDisk(int failing_rename) : failing_rename_(failing_rename) {}
  bool exchange(const fs::path&, const fs::path&) override { return false; }
  void rename(const fs::path& from, const fs::path& to) override {
    if (to.filename() == kUnfinishedMark) return FileSystem::rename(from, to);
    if (++renames_ == failing_rename_) throw Error(ErrorCode::kIo, from, "", "cannot be renamed");
    FileSystem::rename(from, to);
  }

 private:
  const int failing_rename_;
  int renames_ = 0;
};

class PendingFolderReplaces : public ::testing::Test {
 protected:
  PendingFolderReplaces() {
    fs::create_directories(out_);
    writeText(out_ / "old.txt", "old");
  }
  void replaceOn(FileSystem& disk) const {
    PendingFolder folder(out_, "a test", Leftover::kRefuse, disk);
    writeText(folder.path() / "new.txt", "new");
    folder.publish();
    folder.keep();
  }
  const fs::path out_ = freshDirectory("pending_folder") / "out";
};

TEST_F(PendingFolderReplaces, InSteps_removesTheOldFolderLast) {
  PlainDisk disk(0);
  replaceOn(disk);
  EXPECT_TRUE(fs::exists(out_ / "new.txt"));
  EXPECT_FALSE(fs::exists(out_ / "old.txt"));
  EXPECT_FALSE(fs::exists(out_.string() + ".old"));
}

TEST_F(PendingFolderReplaces, InSteps_keepsTheOldFolderIfEitherRenameFails) {
  for (const int failing : {1, 2}) {
    PlainDisk disk(failing);
    expectError([&] { replaceOn(disk); }, ErrorCode::kIo, "cannot be renamed");
    EXPECT_TRUE(fs::exists(out_ / "old.txt")) << failing;
    EXPECT_FALSE(fs::exists(out_.string() + ".old")) << failing;
  }
}

TEST_F(PendingFolderReplaces, InSteps_refusesATakenNameForTheOldFolder) {
  fs::create_directories(out_.string() + ".old");
  PlainDisk disk(0);
  expectError([&] { replaceOn(disk); }, ErrorCode::kExists, "out.old");
  EXPECT_TRUE(fs::exists(out_ / "old.txt"));
}

// No folder is made above the output, as for outputs of one file.
TEST_F(PendingFolderReplaces, AMissingFolderAbove_isRefused) {
  const fs::path above = out_ / "none";
  expectError([&] { PendingFolder(above / "b", "a test", Leftover::kRefuse, FileSystem::real()); },
              ErrorCode::kNotFound, "cannot be made: there is no directory " + above.string());
  EXPECT_FALSE(fs::exists(above));
}

// Files that leave the folder together: b.txt replaces an older file.
class PendingFolderMovesOut : public ::testing::Test {
 protected:
  PendingFolderMovesOut() { writeText(folder_ / "b.txt", "old"); }
  void moveOutOn(FileSystem& disk) const {
    PendingFolder folder(folder_ / "out", "a test", Leftover::kRefuse, disk);
    folder.keep();
    for (const char* name : {"a.txt", "b.txt", "c.txt"}) writeText(folder.path() / name, "new");
    folder.moveOut({folder_ / "a.txt", folder_ / "b.txt", folder_ / "c.txt"});
  }
  std::string textOf(const std::string& name) const {
    return fs::exists(folder_ / name) ? readTextFile(folder_ / name) : "none";
  }
  const fs::path folder_ = freshDirectory("pending_folder_moves");
};

TEST_F(PendingFolderMovesOut, AllFiles_replaceOlderFiles) {
  moveOutOn(FileSystem::real());
  for (const char* name : {"a.txt", "b.txt", "c.txt"}) EXPECT_EQ(textOf(name), "new") << name;
  EXPECT_FALSE(fs::exists(folder_ / "out.partial"));
}

// Links to a file, and to a name that is free.
TEST_F(PendingFolderMovesOut, Links_stayAndTheirTargetsAreReplaced) {
  fs::create_directories(folder_ / "kept");
  writeText(folder_ / "kept" / "old_a.txt", "old");
  fs::create_symlink("kept/old_a.txt", folder_ / "a.txt");
  fs::create_symlink("kept/new_c.txt", folder_ / "c.txt");
  moveOutOn(FileSystem::real());
  for (const char* name : {"a.txt", "c.txt"}) EXPECT_TRUE(fs::is_symlink(folder_ / name)) << name;
  for (const char* name : {"kept/old_a.txt", "b.txt", "kept/new_c.txt"}) EXPECT_EQ(textOf(name), "new") << name;
  EXPECT_FALSE(fs::exists(folder_ / "out.partial"));
}

// b.txt is replaced: the first rename takes the old file away, c.txt is the fourth.
TEST_F(PendingFolderMovesOut, AfterAFailure_bothTheOldAndTheNewFilesAreThere) {
  for (const int failing : {1, 2, 3, 4}) {
    PlainDisk disk(failing);
    expectError([&] { moveOutOn(disk); }, ErrorCode::kIo, "cannot be renamed");
    EXPECT_EQ(textOf("a.txt"), "none") << failing;
    EXPECT_EQ(textOf("b.txt"), "old") << failing;
    for (const char* name : {"a.txt", "b.txt", "c.txt"})
      EXPECT_EQ(textOf(std::string("out.partial/") + name), "new") << failing << name;
    fs::remove_all(folder_ / "out.partial");
  }
}

// A disk that looks at the files before each rename, as they are after a kill.
class WatchedDisk : public FileSystem {
 public:
  explicit WatchedDisk(fs::path folder) : folder_(std::move(folder)) {}
  bool exchange(const fs::path& a, const fs::path& b) override {
    look();
    return FileSystem::exchange(a, b);
  }
  void rename(const fs::path& from, const fs::path& to) override {
    look();
    FileSystem::rename(from, to);
  }
  int mixed() const { return mixed_; }

 private:
  void look() {
    int older = 0, newer = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
      if (!entry.is_regular_file() || entry.path().extension() != ".txt") continue;
      (readTextFile(entry.path()) == "old" ? older : newer) += 1;
    }
    mixed_ += older > 0 && newer > 0 ? 1 : 0;
  }

  const fs::path folder_;
  int mixed_ = 0;
};

TEST_F(PendingFolderMovesOut, AtEachRename_noOldFileLiesBesideANewOne) {
  writeText(folder_ / "a.txt", "old");
  WatchedDisk disk(folder_);
  moveOutOn(disk);
  EXPECT_EQ(disk.mixed(), 0);
  for (const char* name : {"a.txt", "b.txt", "c.txt"}) EXPECT_EQ(textOf(name), "new") << name;
}

// Killed at each rename, and killed again at each rename of the next run. The old files are a.txt, b.txt behind a link,
// and no c.txt.
class PendingFolderKilled : public ::testing::Test {
 protected:
  PendingFolderKilled() {
    fs::create_directories(folder_ / "kept");
    writeText(folder_ / "a.txt", "old");
    writeText(folder_ / "kept/b.txt", "old");
    fs::create_symlink("kept/b.txt", folder_ / "b.txt");
    SnapshotDisk disk(folder_, copies_ / "first");
    PendingFolder folder(folder_ / "out", "a test", Leftover::kRefuse, disk);
    for (const char* name : {"a.txt", "b.txt", "c.txt"}) writeText(folder.path() / name, "new");
    folder.moveOut({folder_ / "a.txt", folder_ / "b.txt", folder_ / "c.txt"});
    snapshots_ = disk.snapshots();
  }
  static std::string textsIn(const fs::path& folder) {
    std::string out;
    for (const char* name : {"a.txt", "kept/b.txt", "c.txt"})
      out += fs::exists(folder / name) ? readTextFile(folder / name) + " " : "none ";
    return out;
  }
  static void rerun(const fs::path& folder, FileSystem& disk, Leftover leftover = Leftover::kRemove) {
    PendingFolder(folder / "out", "a test", leftover, disk);
  }
  const fs::path root_ = freshDirectory("pending_folder_killed"), folder_ = root_ / "work", copies_ = root_ / "killed";
  std::vector<fs::path> snapshots_;
};

TEST_F(PendingFolderKilled, AtEachRename_leavesOldFilesOrNewFilesToTheNextRun) {
  int undone = 0, completed = 0;
  for (const fs::path& killed : snapshots_) {
    const std::string expected = textsIn(killed).find("new") == std::string::npos ? "old old none " : "new new new ";
    (expected == "old old none " ? undone : completed) += 1;
    SnapshotDisk disk(killed, fs::path(killed.string() + "_again"));
    rerun(killed, disk);
    EXPECT_EQ(textsIn(killed), expected) << killed;
    EXPECT_FALSE(fs::exists(killed / "out.partial")) << killed;
    for (const fs::path& again : disk.snapshots()) {
      rerun(again, FileSystem::real());
      EXPECT_EQ(textsIn(again), expected) << again;
    }
  }
  // Before the mark, two old files and the first new file; before the second and third new file.
  EXPECT_EQ(undone, 4);
  EXPECT_EQ(completed, 2);
}

TEST_F(PendingFolderKilled, AContinuedExport_hasTheOldFilesUntilItsEnd) {
  const fs::path& killed = snapshots_.at(3);  // both old files are in the folder
  ASSERT_EQ(textsIn(killed), "none none none ");
  rerun(killed, FileSystem::real(), Leftover::kContinue);
  EXPECT_EQ(textsIn(killed), "old old none ");
  for (const char* name : {"a.txt", "b.txt", "c.txt"}) EXPECT_TRUE(fs::exists(killed / "out.partial" / name)) << name;
}

// Known: only a user can bring another file to the name of an old file, or take a new file away.
TEST_F(PendingFolderKilled, FilesThatWereMovedSince_areRefusedAndStay) {
  writeText(snapshots_.at(3) / "a.txt", "mine");
  expectError([&] { rerun(snapshots_.at(3), FileSystem::real()); }, ErrorCode::kExists, "(found another ");
  EXPECT_EQ(textsIn(snapshots_.at(3)), "mine none none ");
  fs::remove(snapshots_.at(4) / "a.txt");
  expectError([&] { rerun(snapshots_.at(4), FileSystem::real()); }, ErrorCode::kExists, "(found no ");
  for (const int at : {3, 4}) {
    for (const char* name : {"a.txt", "b.txt"})
      EXPECT_EQ(readTextFile(snapshots_.at(at) / "out.partial/replaced" / name), "old") << at << name;
  }
}

// Known: names of one place cannot hold two files.
TEST_F(PendingFolderMovesOut, TwoLinksToOnePlace_areRefusedBeforeTheWork) {
  fs::create_symlink("one.txt", folder_ / "a.txt");
  fs::create_symlink("one.txt", folder_ / "c.txt");
  PendingFolder folder(folder_ / "out", "a test", Leftover::kRefuse, FileSystem::real());
  folder.requirePlaces({folder_ / "a.txt", folder_ / "b.txt"});
  expectError(
      [&] {
        folder.requirePlaces({folder_ / "a.txt", folder_ / "b.txt", folder_ / "c.txt"});
      },
      ErrorCode::kUsage, "c.txt: leads to");
}

// Known: a folder, a link to a folder and a pipe hold what no export may remove.
TEST_F(PendingFolderMovesOut, WhatIsNoFile_isRefusedBeforeTheWorkAndStays) {
  for (const char* name : {"kept", "a.txt"}) {
    fs::create_directory(folder_ / name);
    writeText(folder_ / name / "notes.md", "mine");
  }
  fs::create_directory_symlink("kept", folder_ / "c.txt");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  {
    PendingFolder folder(folder_ / "out", "a test", Leftover::kRefuse, FileSystem::real());
    for (const char* name : {"a.txt", "c.txt"}) {
      expectError(
          [&] {
            folder.requirePlaces({folder_ / "b.txt", folder_ / name});
          },
          ErrorCode::kExists, std::string(name) + ": an export replaces only files (found a directory)");
    }
    expectError([&] { folder.requirePlaces({folder_ / "pipe"}); }, ErrorCode::kExists, "(found a device, a pipe");
  }
  // A folder may also come during the work.
  expectError([&] { moveOutOn(FileSystem::real()); }, ErrorCode::kExists, "a.txt: an export replaces only files");
  for (const char* name : {"a.txt/notes.md", "kept/notes.md"}) EXPECT_EQ(textOf(name), "mine") << name;
  EXPECT_EQ(textOf("b.txt"), "old");
}

// Known: no file is renamed from one disk to another. /dev/shm is a disk of its own.
TEST_F(PendingFolderMovesOut, LinkToAnotherDisk_isRefusedBeforeTheWork) {
  const fs::path other = fs::path("/dev/shm") / ("kiln_pending_folder_" + std::to_string(::getpid()));
  std::error_code unknown;
  if (!fs::create_directory(other, unknown)) GTEST_SKIP() << "needs a writable /dev/shm";
  if (identityOf(other)->device == identityOf(folder_)->device) {
    fs::remove_all(other);
    GTEST_SKIP() << "needs two disks";
  }
  fs::create_symlink(other / "a.txt", folder_ / "a.txt");
  {
    PendingFolder folder(folder_ / "out", "a test", Leftover::kRefuse, FileSystem::real());
    expectError([&] { folder.requirePlaces({folder_ / "a.txt"}); }, ErrorCode::kUsage, "on another disk");
  }
  EXPECT_TRUE(fs::is_empty(other));
  EXPECT_FALSE(fs::exists(folder_ / "out.partial"));
  fs::remove_all(other);
}

}  // namespace
}  // namespace kiln::test
