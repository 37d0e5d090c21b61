// What is written is what is read, whichever way it goes to the disk. Sizes around a block and the buffer of writes
// that go past the page cache; on a file system that cannot do that, the test shows that nothing depends on it.
#include "base/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <optional>
#include <thread>

#include "base/error.h"
#include "support/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

TEST(FileSystem, WritesTheSameBytesInEveryMode) {
  const fs::path directory = freshDirectory("write_modes");
  for (const std::size_t size : {0u, 1u, 4095u, (1u << 20) - 1, 1u << 20, (1u << 20) + 1, (3u << 20) + 4096 + 7}) {
    std::vector<std::byte> data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::byte>(i * 2654435761u >> 13);
    for (const WriteMode mode : {WriteMode::kSynced, WriteMode::kUnsynced, WriteMode::kPastCache}) {
      const fs::path path = directory / "file";
      FileSystem::real().writeOwn(path, data, mode);
      EXPECT_EQ(readFile(path), data) << size << " bytes, mode " << static_cast<int>(mode);
    }
  }
}

// In a directory of Kiln's own what is in the way of the temporary name may be somebody's all the same.
TEST(FileSystem, LeavesADirectoryOfTheTemporaryName) {
  const fs::path path = freshDirectory("in_the_way") / "file";
  fs::create_directory(path.string() + ".tmp");
  EXPECT_THROW(FileSystem::real().writeOwn(path, std::string("text")), Error);
  EXPECT_TRUE(fs::is_directory(path.string() + ".tmp"));
  EXPECT_FALSE(fs::exists(path));
}

// Known because two files are made and one name is in the way: what is there afterwards is these, and nothing else.
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

// As two machines do that draw the same frames: whoever was last, the file is one of theirs and whole.
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
  EXPECT_NE(codeFor("/proc/a.png"), std::nullopt);  // who may write anywhere may not there
}

// A pipe without a reader keeps its writer waiting; the signal of Ctrl-C has to end the wait.
TEST(FileSystem, WaitForTheReaderOfAPipe_signal_endsWithAnError) {
  const fs::path path = freshDirectory("pipe_without_reader") / "pipe";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  struct sigaction note {}, before {};
  note.sa_handler = [](int) {};
  ASSERT_EQ(sigaction(SIGUSR1, &note, &before), 0);
  std::atomic<bool> ended = false;
  bool refused = false;
  std::thread writer([&] {
    try {
      FileSystem::real().writeAtomic(path, std::string("text"));
    } catch (const Error&) {
      refused = true;
    }
    ended = true;
  });
  for (int i = 0; i < 200 && !ended; ++i) {  // 2 s; a signal before the wait has no effect
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (!ended) pthread_kill(writer.native_handle(), SIGUSR1);
  }
  const bool in_time = ended;
  // A reader ends the wait in any case, so that a failure is reported.
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  writer.join();
  ::close(reader);
  sigaction(SIGUSR1, &before, nullptr);
  EXPECT_TRUE(in_time);
  EXPECT_TRUE(refused);
}

// Known because a pipe gives what was put into it, in order; it holds less than this at a time.
TEST(FileSystem, WritesToAPipe) {
  const fs::path path = freshDirectory("pipe") / "pipe";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { read.assign(std::istreambuf_iterator(std::ifstream(path).rdbuf()), {}); });
  const std::string text(300000, 'k');
  EXPECT_NO_THROW(FileSystem::real().writeAtomic(path, text));
  reader.join();
  EXPECT_EQ(read, text);
}

}  // namespace
}  // namespace kiln::test
