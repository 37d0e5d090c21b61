// Files read back exactly as written, by every write policy. Sizes lie around a block and around the buffer of direct
// writes (past the page cache). On a file system without direct writes the test covers the fallback.
#include "base/file/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <thread>

#include "base/error.h"
#include "base/file/renamed_error.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

TEST(FileSystem, WritesTheSameBytesByEveryPolicy) {
  const fs::path directory = freshDirectory("write_policies");
  for (const std::size_t size : {0u, 1u, 4095u, (1u << 20) - 1, 1u << 20, (1u << 20) + 1, (3u << 20) + 4096 + 7}) {
    std::vector<std::byte> data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::byte>(i * 2654435761u >> 13);
    for (const WritePolicy policy :
         {WritePolicy::kSynced, WritePolicy::kUnsynced, WritePolicy::kBegun, WritePolicy::kPastCache}) {
      const fs::path path = directory / "file";
      FileSystem::real().writeOwn(path, data, policy);
      EXPECT_EQ(readFile(path), data) << size << " bytes, policy " << static_cast<int>(policy);
    }
  }
}

// Even in a directory that Kiln owns, a directory with the temporary name may belong to the user and stays.
TEST(FileSystem, LeavesADirectoryOfTheTemporaryName) {
  const fs::path path = freshDirectory("in_the_way") / "file";
  fs::create_directory(path.string() + ".tmp");
  EXPECT_THROW(FileSystem::real().writeOwn(path, std::string("text")), Error);
  EXPECT_TRUE(fs::is_directory(path.string() + ".tmp"));
  EXPECT_FALSE(fs::exists(path));
}

// Known because exactly three entries exist afterwards: the user's file, the written file and the directory in the way.
TEST(FileSystem, LeavesFilesWithNamesLikeTemporaryOnes) {
  const fs::path directory = freshDirectory("like_temporary"), path = directory / "file";
  std::ofstream(path.string() + ".tmp") << "mine";
  FileSystem::real().writeAtomic(path, std::string("text"));
  EXPECT_EQ(readTextFile(path), "text");
  EXPECT_EQ(readTextFile(path.string() + ".tmp"), "mine");
  fs::create_directories(directory / "full" / "inside");
  EXPECT_THROW(FileSystem::real().writeAtomic(directory / "full", std::string("text")), Error);
  EXPECT_EQ(std::distance(fs::directory_iterator(directory), {}), 3) << "the failed one left something";
}

// Two machines may draw equal frames into a file: afterwards the file is one of the two versions, and whole.
TEST(FileSystem, TwoMayWriteTheSameFile) {
  const fs::path directory = freshDirectory("two_writers"), path = directory / "file";
  const auto write = [&](char letter, std::size_t size) {
    const std::string text(size, letter);
    for (int i = 0; i < 20; ++i) EXPECT_NO_THROW(FileSystem::real().writeAtomic(path, text));
  };
  std::thread other(write, 'a', std::size_t{1} << 20);
  write('b', std::size_t{3} << 19);
  other.join();
  const std::string text = readTextFile(path);
  EXPECT_TRUE(text == std::string(std::size_t{1} << 20, 'a') || text == std::string(std::size_t{3} << 19, 'b'))
      << text.size() << " bytes";
  EXPECT_EQ(std::distance(fs::directory_iterator(directory), {}), 1);
}

TEST(FileSystem, KnowsWhereNothingCanBeMade) {
  const fs::path directory = freshDirectory("places");
  const auto codeFor = [](const fs::path& path) -> std::optional<ErrorCode> {
    try {
      FileSystem::real().requirePlaceFor(path);
    } catch (const Error& error) {
      return error.code();
    }
    return std::nullopt;
  };
  EXPECT_EQ(codeFor(directory / "a.png"), std::nullopt);
  EXPECT_TRUE(fs::is_empty(directory));
  std::ofstream(directory / "there.png") << "before";
  EXPECT_EQ(codeFor(directory / "there.png"), std::nullopt);
  EXPECT_EQ(readTextFile(directory / "there.png"), "before");
  EXPECT_EQ(codeFor("/dev/null"), std::nullopt);
  EXPECT_EQ(codeFor(directory / "none" / "a.png"), ErrorCode::kNotFound);
  EXPECT_EQ(codeFor(directory / "there.png" / "a.png"), ErrorCode::kNotFound);
  EXPECT_EQ(codeFor(directory), ErrorCode::kIo);
  EXPECT_NE(codeFor("/proc/a.png"), std::nullopt);  // fails also for users with all permissions
}

// Known because the system would end the name at the NUL, where there is a file of the user's.
TEST(FileSystem, ANameWithANulReachesNoFile) {
  const fs::path directory = freshDirectory("nul"), thesis = directory / "thesis.tex";
  writeText(thesis, "mine");
  const fs::path cut(thesis.string() + std::string("\0.png", 5));
  FileSystem& disk = FileSystem::real();
  EXPECT_THROW(disk.writeAtomic(cut, std::string("text")), Error);
  EXPECT_THROW(disk.writeOwn(cut, std::string("text")), Error);
  EXPECT_THROW(disk.appendFile(cut, bytesOf("text")), Error);
  EXPECT_THROW(disk.removeAll(cut), Error);
  EXPECT_THROW(disk.requirePlaceFor(cut), Error);
  EXPECT_THROW(disk.rename(thesis, cut), Error);
  EXPECT_THROW(readFile(cut), Error);
  EXPECT_EQ(readTextFile(thesis), "mine");
}

// Known because neither link leads to a file: there is nothing to replace.
TEST(FileSystem, ALoopOfLinksStays) {
  const fs::path directory = freshDirectory("link_loop"), a = directory / "a.png", b = directory / "b.png";
  fs::create_symlink("b.png", a);
  fs::create_symlink("a.png", b);
  FileSystem& disk = FileSystem::real();
  EXPECT_THROW(disk.requirePlaceFor(a), Error);
  EXPECT_THROW(disk.writeAtomic(a, std::string("text")), Error);
  EXPECT_EQ(fs::read_symlink(a), "b.png");
  EXPECT_EQ(fs::read_symlink(b), "a.png");
}

// A nameless scratch file fails under its folder's name, which a user did not write.
TEST(RenamedError, HasTheNameThatTheUserGave) {
  const Error full(ErrorCode::kNoSpace, ".", "writing at byte 8192", "No space left on device");
  const Error named = renamed(full, ".", "o.exr");
  EXPECT_STREQ(named.what(), "o.exr: writing at byte 8192: No space left on device");
  EXPECT_EQ(named.path(), "o.exr");
  EXPECT_EQ(named.code(), ErrorCode::kNoSpace);
  EXPECT_STREQ(renamed(full, "elsewhere", "o.exr").what(), full.what());
}

// A pipe without a reader blocks its writer forever, and a pipe whose reader exits loses the rest.
TEST(FileSystem, APipeAndASocketAreNoOutputs) {
  const fs::path directory = freshDirectory("special"), pipe = directory / "pipe", socket = directory / "socket";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int listening = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un name{AF_UNIX, {}};
  // Names of sockets are short, so the socket is bound by its file name in the current folder.
  const fs::path before = fs::current_path();
  fs::current_path(directory);
  std::strcpy(name.sun_path, "socket");
  ASSERT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  fs::current_path(before);
  for (const fs::path& path : {pipe, socket}) {
    try {
      FileSystem::real().requirePlaceFor(path);
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.exitCode(), 2);
      EXPECT_TRUE(std::string(error.what()).ends_with("name a file")) << error.what();
    }
  }
  ::close(listening);
  // A pipe made while the command runs is replaced by the file.
  EXPECT_NO_THROW(FileSystem::real().writeAtomic(pipe, std::string("text")));
  EXPECT_EQ(readTextFile(pipe), "text");
  ASSERT_EQ(mkfifo((directory / "own.tmp").c_str(), 0600), 0);
  EXPECT_NO_THROW(FileSystem::real().writeOwn(directory / "own", std::string("text")));
  EXPECT_EQ(readTextFile(directory / "own"), "text");
}

}  // namespace
}  // namespace kiln::test
