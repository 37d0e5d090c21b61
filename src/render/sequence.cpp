#include "render/sequence.h"

#include <memory>
#include <optional>

#include "base/file.h"
#include "base/parallel.h"
#include "base/trace.h"
#include "render/frame_checkpoint.h"
#include "render/shared_sequence.h"

namespace kiln {
namespace {

class Sequence {
 public:
  Sequence(const RenderJob& job, const SequenceOptions& options, Progress& progress, SequenceListener& listener)
      : job_(job),
        resume_(options.resume),
        checkpoint_(options.checkpoint),
        progress_(progress),
        listener_(listener),
        frames_(job, options.store_for, progress, options.checkpoint ? checkpointBytes(job) : 0) {}

  SequenceResult run() {
    if (checkpoint_) requireCheckpoint(job_);
    frames_.makeFolders();
    frames_.requireScenes();
    listener_.started(job_, frames_.numbers());
    for (const int frame : frames_.numbers()) {
      handle(frame);
      ++done_;
    }
    frames_.describeMemory(result_.statistics);
    if (result_.statistics.failed.empty()) frames_.makeVideo();
    return std::move(result_);
  }

 private:
  void handle(int frame) {
    try {
      progress_.throwIfCancelled("rendering");
      if (resume_ && frames_.isThere(frame)) {
        if (checkpoint_) FileSystem::real().removeAll(checkpointOf(job_, frame));
        result_.statistics.kept.push_back(frame);
        listener_.frameKept(job_, frame, done_ + 1);
      } else {
        draw(frame, frames_.openedFor(frame));
      }
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kExists || frames_.numbers().size() == 1) throw;
      if (error.code() == ErrorCode::kCancelled) throw frames_.interrupted(done_ - result_.statistics.failed.size());
      if (result_.statistics.failed.empty()) result_.first_failure = error.what();
      result_.statistics.failed.push_back(frame);
      listener_.frameFailed(frame, error, done_ + 1);
    }
  }

  void draw(int frame, OpenedJob& opened) {
    listener_.frameStarted(frame);
    DrawnFrame drawn = checkpoint_ ? drawInTiles(opened, frame, resume_, progress_) : opened.draw(frame, progress_);
    writeFrame(opened.job(), frame, drawn, opened.store());
    if (checkpoint_) FileSystem::real().removeAll(checkpointOf(opened.job(), frame));
    result_.statistics.add(drawn.statistics);
    noteDamage(drawn.statistics, progress_);
    listener_.frameDone(job_, drawn.statistics, done_ + 1);
  }

  const RenderJob& job_;
  const bool resume_, checkpoint_;
  Progress& progress_;
  SequenceListener& listener_;
  SequenceFrames frames_;
  std::size_t done_ = 0;
  SequenceResult result_;
};

// Each rank has its own clock and its own file: NAME.json is the first one's, then NAME.1.json.
std::filesystem::path traceOfRank(const std::filesystem::path& trace, const Ranks* ranks) {
  if (ranks == nullptr || ranks->first()) return trace;
  const std::string number = "." + std::to_string(ranks->rank());
  return trace.parent_path() / (trace.stem().string() + number + trace.extension().string());
}

}  // namespace

SequenceResult runSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                           SequenceListener& listener) {
  const ThreadLimit threads(job.speed.threads);
  std::optional<Trace> trace;
  if (!job.trace.empty()) trace.emplace(traceOfRank(job.trace, options.ranks));
  SequenceResult result = options.ranks != nullptr && !options.ranks->alone()
                              ? shareSequence(job, options, progress, listener)
                              : Sequence(job, options, progress, listener).run();
  if (trace) trace->finish();
  return result;
}

}  // namespace kiln
