// The files of a sequence's frame are written while the next frame is drawn, if memory allows. Known from a job with
// the least memory that works, and from a job with a single thread.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/file/file.h"
#include "base/thread/parallel.h"
#include "sequence/opened_job.h"
#include "sequence/sequence.h"
#include "support/reference/function_bytes.h"
#include "support/system/expect_error.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Records whether the second frame started before the first was done.
struct Ordered : SequenceListener {
  void frameStarted(int frame) override { second_began = second_began || frame == 2; }
  void frameDone(const RenderJob&, const FrameStatistics& frame, std::size_t) override {
    if (frame.frame == 1) second_began_first = second_began;
  }
  bool second_began = false, second_began_first = false;
};

class FramesBehind : public ::testing::Test {
 protected:
  void SetUp() override {
    job_.volume =
        makeStore(head({{40, 41, 37}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8)), "behind", 16);
    folder_ = job_.volume.parent_path();
    job_.picture.size = {48, 40};
    job_.picture.samples = 1;  // equal to the least memory below
    job_.speed.threads = 2;
    job_.animation.camera = Turntable{5, 360, std::nullopt};
    job_.frames = {1, 2, 3, 4, 5};
  }
  // The frames' files.
  std::vector<std::string> drawn(const std::string& name) {
    job_.output.path = folder_ / (name + "_#.png");
    Ordered order;
    Progress silent;
    runSequence(job_, {}, silent, order);
    second_began_first_ = order.second_began_first;
    std::vector<std::string> out;
    for (const int frame : job_.frames) out.push_back(readTextFile(folder_ / fmt::format("{}_{}.png", name, frame)));
    return out;
  }
  std::unique_ptr<OpenedJob> opened() { return std::make_unique<OpenedJob>(job_, silent_, 0, nullptr, true); }

  Progress silent_;
  RenderJob job_;
  fs::path folder_;
  bool second_began_first_ = false;  // of the last call of `drawn`
};

TEST_F(FramesBehind, AreTheSame) {
  const std::vector<std::string> ample = drawn("ample");
  EXPECT_TRUE(second_began_first_);
  EXPECT_TRUE(opened()->writesBehind());
  const StoreReader store(job_.volume);
  const FrameMemory memory = frameMemory(store, job_);
  job_.speed.memory_bytes = memory.smallest() + functionBytesOf(job_);
  EXPECT_FALSE(opened()->writesBehind());
  EXPECT_EQ(drawn("small"), ample);
  EXPECT_FALSE(second_began_first_);
  job_.speed.memory_bytes = 1ull << 30;
  job_.speed.threads = 1;
  EXPECT_EQ(drawn("one"), ample);
  EXPECT_FALSE(second_began_first_);
}

// A picture and its file, 16 bytes a pixel each, are charged, and the budget is the sum as before.
TEST_F(FramesBehind, AreCharged) {
  RenderStatistics with, without;
  opened()->describeMemory(with);
  OpenedJob(job_, silent_).describeMemory(without);
  EXPECT_EQ(with.framebuffer_bytes, without.framebuffer_bytes + 32u * 48 * 40);
  EXPECT_EQ(with.cache_bytes + 32u * 48 * 40, without.cache_bytes);
}

// An obstacle that appears after the start of a frame is detected when the file is written; an earlier obstacle, before
// the frame is drawn.
TEST_F(FramesBehind, AFileThatCannotBeWrittenCostsItsFrameOnly) {
  const std::vector<std::string> all = drawn("all");
  for (const bool before : {false, true}) {
    SCOPED_TRACE(before);
    const std::string name = before ? "before" : "since";
    struct Listening : SequenceListener {
      void frameStarted(int frame) override {
        started.push_back(frame);
        if (frame == 2) fs::create_directories(in_the_way);
      }
      fs::path in_the_way;
      std::vector<int> started;
    } listener;
    listener.in_the_way = folder_ / (name + "_2.png") / "in_the_way";
    if (before) fs::create_directories(listener.in_the_way);
    job_.output.path = folder_ / (name + "_#.png");
    Progress silent;
    const SequenceResult result = runSequence(job_, {}, silent, listener);
    EXPECT_EQ(listener.started, (before ? std::vector<int>{1, 3, 4, 5} : std::vector<int>{1, 2, 3, 4, 5}));
    EXPECT_EQ(result.statistics.failed, std::vector<int>{2});
    EXPECT_NE(result.first_failure.find(name + "_2.png"), std::string::npos) << result.first_failure;
    ASSERT_EQ(result.statistics.frames.size(), 4u);
    for (const int frame : {1, 3, 4, 5}) {
      const fs::path file = folder_ / fmt::format("{}_{}.png", name, frame);
      EXPECT_EQ(readTextFile(file), all[static_cast<std::size_t>(frame) - 1]);
    }
  }
}

// A frame that could not be written fails before a later frame, also if the later frame has an error itself.
TEST_F(FramesBehind, FailInTheirOrder) {
  job_.output.path = folder_ / "order_#.png";
  struct Failing : Progress {
    bool cancelled() const override {
      if (fails) throw Error(ErrorCode::kIo, "frame 3", "", "cannot be drawn");
      return false;
    }
    bool fails = false;
  } progress;
  struct Listening : SequenceListener {
    Listening(Failing& the_progress, fs::path the_obstacle) : progress(the_progress), in_the_way(the_obstacle) {}
    void frameStarted(int frame) override {
      progress.fails = frame == 3;
      if (frame == 2) fs::create_directories(in_the_way);
    }
    void frameFailed(int frame, const Error&, std::size_t) override { progress.fails = progress.fails && frame != 3; }
    Failing& progress;
    fs::path in_the_way;
  } listener(progress, folder_ / "order_2.png/in_the_way");
  const SequenceResult result = runSequence(job_, {}, progress, listener);
  EXPECT_EQ(result.statistics.failed, (std::vector<int>{2, 3}));
  EXPECT_NE(result.first_failure.find("order_2.png"), std::string::npos) << result.first_failure;
}

// After a job is stopped, all reported frames exist, and so does the frame that was being written.
TEST_F(FramesBehind, OfAStoppedJobAreThere) {
  struct Stopping : Progress {
    bool cancelled() const override { return stop; }
    bool stop = false;
  } progress;
  struct Listening : SequenceListener {
    explicit Listening(Stopping& the_progress) : progress(the_progress) {}
    void frameStarted(int frame) override { progress.stop = frame == 4; }
    void frameDone(const RenderJob&, const FrameStatistics& frame, std::size_t) override {
      done.push_back(frame.frame);
    }
    Stopping& progress;
    std::vector<int> done;
  } listener(progress);
  job_.output.path = folder_ / "stopped_#.png";
  expectError([&] { runSequence(job_, {}, progress, listener); }, ErrorCode::kCancelled, "3 of 5 frames are there");
  EXPECT_EQ(listener.done, (std::vector<int>{1, 2, 3}));
  EXPECT_TRUE(fs::exists(folder_ / "stopped_3.png"));
  EXPECT_FALSE(fs::exists(folder_ / "stopped_4.png"));
}

}  // namespace
}  // namespace kiln::test
