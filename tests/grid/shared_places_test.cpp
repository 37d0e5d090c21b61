// Files and directories in folders that other users may write to. Links are not followed, other users' files are not
// overwritten, and a killed process leaves no obstacle. Tests with several users change owners and need the
// administrator's rights.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/file_lock.h"
#include "base/file/same_file.h"
#include "base/file/temporary_file.h"
#include "convert/resume/output_directory.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr uid_t kOther = 12345;

bool mayChangeOwners() { return ::geteuid() == 0; }

// Returns the message of the error, or an empty text.
template <class F>
std::string refusal(F&& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

// Runs body() in a process that then ends without destructors, like a killed process.
template <class F>
void inKilledProcess(F&& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    body();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
}

TEST(SharedPlaces, ALinkInTheWayOfATemporaryName_IsReplacedAndNotFollowed) {
  const fs::path directory = freshDirectory("planted"), victim = directory / "victim";
  for (const bool hard : {false, true}) {
    writeText(victim, "precious");
    const fs::path path = directory / "file", planted = path.string() + ".tmp";
    if (hard)
      fs::create_hard_link(victim, planted);
    else
      fs::create_symlink(victim, planted);
    FileSystem::real().writeOwn(path, std::string("text"));
    EXPECT_EQ(readTextFile(victim), "precious") << hard;
    EXPECT_EQ(readTextFile(path), "text");
    EXPECT_FALSE(fs::is_symlink(path));
  }
}

TEST(SharedPlaces, ALinkOfThisUser_IsWrittenThrough) {
  const fs::path directory = freshDirectory("own_link");
  fs::create_directories(directory / "real");
  fs::create_symlink("real/p.png", directory / "p.png");
  FileSystem::real().writeAtomic(directory / "p.png", std::string("text"));
  EXPECT_EQ(readTextFile(directory / "real/p.png"), "text");
  EXPECT_TRUE(fs::is_symlink(directory / "p.png"));
}

TEST(SharedPlaces, ALinkOfAnotherUser_IsRefused) {
  if (!mayChangeOwners()) GTEST_SKIP() << "needs the administrator to change a link's owner";
  const fs::path directory = freshDirectory("foreign_link"), victim = directory / "victim";
  writeText(victim, "precious");
  fs::create_symlink(victim, directory / "p.png");
  ASSERT_EQ(::lchown((directory / "p.png").c_str(), kOther, kOther), 0);
  EXPECT_NE(refusal([&] {
              FileSystem::real().writeAtomic(directory / "p.png", std::string("text"));
            }).find("is a link made by another user"),
            std::string::npos);
  EXPECT_EQ(readTextFile(victim), "precious");
}

TEST(SharedPlaces, AnEmptyDirectoryThatOthersControl_IsNoPlaceForAStore) {
  const fs::path out = freshDirectory("shared_out") / "v.kiln";
  const auto begin = [&] { OutputDirectory(out, false, false, FileSystem::real()); };
  fs::create_directory(out);
  EXPECT_EQ(refusal(begin), "");
  fs::permissions(out, fs::perms::all);
  EXPECT_NE(refusal(begin).find("is writable by every user"), std::string::npos);
  fs::permissions(out, fs::perms::owner_all | fs::perms::group_all);  // a folder of a group that works together
  EXPECT_EQ(refusal(begin), "");
  // A link to an own directory is a usual way to another disk.
  fs::create_symlink("v.kiln", out.parent_path() / "link.kiln");
  EXPECT_EQ(refusal([&] { OutputDirectory(out.parent_path() / "link.kiln", false, false, FileSystem::real()); }), "");
  if (!mayChangeOwners()) GTEST_SKIP() << "needs the administrator to change a directory's owner";
  ASSERT_EQ(::chown(out.c_str(), kOther, kOther), 0);
  EXPECT_NE(refusal(begin).find("belongs to another user"), std::string::npos);
}

TEST(FileLock, OfAKilledProcess_IsFreeAtOnce) {
  const fs::path path = freshDirectory("killed_lock") / "v.lock";
  inKilledProcess([&] { new FileLock(path, [] {}); });
  EXPECT_TRUE(fs::exists(path)) << "the process was to end without its destructor";
  int waits = 0;
  {
    const FileLock lock(path, [&] { ++waits; });
  }
  EXPECT_EQ(waits, 0);
  EXPECT_FALSE(fs::exists(path));
}

TEST(FileLock, ThatIsHeld_IsRefusedOrWaitedFor) {
  const fs::path out = freshDirectory("held_lock") / "v.kiln";
  auto held = std::make_unique<FileLock>(lockOf(out), [] {});
  const std::string text = refusal([&] { FileLock(lockOf(out), refusalOf(out)); });
  EXPECT_NE(text.find("is being written by kiln process " + std::to_string(::getpid()) + " on "), std::string::npos)
      << text;
  int waits = 0;
  const FileLock waited(lockOf(out), [&] {
    ++waits;
    held.reset();
  });
  EXPECT_EQ(waits, 1);
}

TEST(FileLock, AFileOfThatNameThatIsNoLock_IsLeft) {
  const fs::path path = freshDirectory("no_lock") / "v.lock";
  writeText(path, "somebody's notes");
  EXPECT_NE(refusal([&] { FileLock(path, [] {}); }).find("has the name of a lock file, but is none; move it"),
            std::string::npos);
  EXPECT_EQ(readTextFile(path), "somebody's notes");
}

TEST(TemporaryFile, OfAKilledProcess_IsUsedAgain) {
  const fs::path directory = freshDirectory("killed_temporary"), path = directory / "p.png";
  for (int i = 0; i < 3; ++i) inKilledProcess([&] { new TemporaryFile(path); });
  EXPECT_EQ(std::distance(fs::directory_iterator(directory), {}), 1);
  {
    const TemporaryFile first(path), second(path);
    EXPECT_NE(first.path(), second.path());
  }
  EXPECT_TRUE(fs::is_empty(directory));
}

// Files of killed processes in any slot go with the next file of the name; a running process keeps its own.
TEST(TemporaryFile, OfKilledProcesses_AreRemovedByTheNextOfTheName) {
  const fs::path directory = freshDirectory("killed_temporaries"), path = directory / "p.png";
  writeText(directory / "q.png.kiln-001.tmp", "of another name");
  const auto slot = [&](int number) { return path.string() + ".kiln-00" + std::to_string(number) + ".tmp"; };
  const auto leave = [&] {
    inKilledProcess([&] {
      for (int i = 0; i < 4; ++i) new TemporaryFile(path);
    });
  };
  leave();
  {
    const TemporaryFile running(path);
    EXPECT_EQ(running.path(), slot(1));
    for (int i = 2; i <= 4; ++i) EXPECT_FALSE(fs::exists(slot(i))) << i;
    leave();
    FileSystem::real().writeAtomic(path, std::string("text"));
    for (int i = 2; i <= 5; ++i) EXPECT_FALSE(fs::exists(slot(i))) << i;
    EXPECT_TRUE(fs::exists(slot(1))) << "of a running process";
  }
  leave();
  TemporaryFile::removeLeftovers(path);
  EXPECT_EQ(std::distance(fs::directory_iterator(directory), {}), 2) << "the picture, and the file of another name";
}

TEST(TemporaryFile, OfAnotherUser_IsLeft) {
  if (!mayChangeOwners()) GTEST_SKIP() << "needs the administrator to change a file's owner";
  const fs::path directory = freshDirectory("foreign_temporary"), path = directory / "p.png";
  const fs::path foreign = path.string() + ".kiln-001.tmp";
  writeText(foreign, "theirs");
  ASSERT_EQ(::chown(foreign.c_str(), kOther, kOther), 0);
  FileSystem::real().writeAtomic(path, std::string("text"));
  EXPECT_EQ(readTextFile(path), "text");
  EXPECT_EQ(readTextFile(foreign), "theirs");
}

}  // namespace
}  // namespace kiln::test
