#include "base/worker_process.h"

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "base/file/file.h"

namespace kiln {
namespace {

// The kinds of support/system/failing_worker.
enum Kind : std::uint32_t { kAnswer, kRefuse, kCrash, kSleep, kSpin, kMemory, kEnd, kExit, kPrint };

constexpr std::uint64_t kMemoryBytes = 256 << 20;

WorkerProcess worker(int request_s = 60) {
  return WorkerProcess(KILN_TEST_WORKER, "the library", {.memory_bytes = kMemoryBytes, .request_s = request_s});
}

std::string answered(WorkerProcess& process, std::uint32_t kind, const std::string& first,
                     const std::string& second = {}) {
  const WorkerPlace place{"a.dcm", "frame 7"};
  const std::uint64_t bytes =
      process.request(place, kind, {std::as_bytes(std::span(first)), std::as_bytes(std::span(second))});
  std::string out(bytes, '\0');
  process.receive(place, std::as_writable_bytes(std::span(out)));
  return out;
}

void expectFails(WorkerProcess& process, std::uint32_t kind, const std::string& text, const std::string& payload = {}) {
  try {
    answered(process, kind, payload);
    ADD_FAILURE() << "no error: " << text;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFormat);
    EXPECT_EQ(error.what(), "a.dcm: frame 7: " + text);
  }
}

// Known because the worker doubles its payload. The last is longer than a socket's buffers.
TEST(WorkerProcess, AnswersOneRequestAfterAnother) {
  WorkerProcess process = worker();
  EXPECT_EQ(answered(process, kAnswer, ""), "");
  EXPECT_EQ(answered(process, kAnswer, "ab", "c"), "abcabc");
  const std::string long_text(5'000'000, 'x');
  EXPECT_EQ(answered(process, kAnswer, long_text).size(), 2 * long_text.size());
}

TEST(WorkerProcess, ARefusal_isAnErrorAndTheWorkerGoesOn) {
  WorkerProcess process = worker();
  expectFails(process, kRefuse, "has no meaning");
  EXPECT_EQ(answered(process, kAnswer, "ab"), "abab");
}

// Known: answers have a socket of their own, and messages beyond a MiB are dropped.
TEST(WorkerProcess, ALibraryThatPrints_changesNoAnswer) {
  WorkerProcess process = worker();
  EXPECT_EQ(answered(process, kPrint, ""), "printed");
  EXPECT_EQ(answered(process, kAnswer, "ab"), "abab");
}

TEST(WorkerProcess, AWorkerThatEnds_isAnErrorWithTheReason) {
  WorkerProcess crash = worker(), end = worker(), exit = worker();
  expectFails(crash, kCrash, "the library failed: its process was ended by signal 6: an assertion failed");
  // The program stays ended.
  expectFails(crash, kAnswer, "the library failed: its process ended: an assertion failed");
  expectFails(end, kEnd, "the library failed: its process ended");
  expectFails(exit, kExit, "the library failed: its process failed with exit code 3");
}

TEST(WorkerProcess, AWorkerThatHangs_isAnErrorInTime) {
  WorkerProcess sleeping = worker(1), spinning = worker(1);
  expectFails(sleeping, kSleep, "the library failed: its process did not answer for 1 s");
  expectFails(spinning, kSpin, "the library failed: its process did not answer for 1 s");
}

// Known because a process cannot map more than its limit.
TEST(WorkerProcess, AWorkerThatTakesTooMuchMemory_isAnErrorAndTheWorkerGoesOn) {
  WorkerProcess process = worker();
  expectFails(process, kMemory, "the library needs more memory than the 256 MiB of its process");
  EXPECT_EQ(answered(process, kAnswer, "ab"), "abab");
  // Its request alone exceeds its memory.
  expectFails(process, kAnswer, "the library needs more memory than the 256 MiB of its process",
              std::string(300 << 20, 'x'));
  EXPECT_EQ(answered(process, kAnswer, "ab"), "abab");
}

TEST(WorkerProcess, AProgramThatIsAbsent_isNotFound) {
  try {
    WorkerProcess("/nowhere/worker", "the library", {});
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotFound);
  }
}

}  // namespace
}  // namespace kiln
