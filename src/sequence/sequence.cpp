#include "sequence/sequence.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "base/file/file.h"
#include "base/file/file_lock.h"
#include "base/thread/parallel.h"
#include "base/thread/trace.h"
#include "base/thread/worker_thread.h"
#include "cluster/agreement.h"
#include "frame/empty_frame.h"
#include "job/job_facts.h"
#include "sequence/brick_sequence.h"
#include "sequence/frame_checkpoint.h"
#include "sequence/rank_facts.h"
#include "sequence/series_volumes.h"
#include "sequence/shared_sequence.h"

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
        frames_(job, options.store_for, progress, besideBytes(job, options), {.writes_behind = writesBehind(job)}) {}

  SequenceResult run() {
    if (checkpoint_) requireCheckpoint(job_);
    frames_.makeFolders();
    frames_.requireScenes();
    if (resume_) frames_.findVideo();
    listener_.started(job_, frames_.numbers());
    for (const int frame : frames_.numbers()) attempt(frame, [&] { handle(frame); });
    finishWriting();
    frames_.describeMemory(result_.statistics);
    if (result_.statistics.failed.empty()) frames_.makeVideo();
    return std::move(result_);
  }

 private:
  // A drawn frame whose files are being written.
  struct Unwritten {
    int frame;
    OpenedJob& opened;
    DrawnFrame drawn;
  };

  // Runs `body`; an error fails this frame only.
  void attempt(int frame, const std::function<void()>& body) {
    try {
      body();
    } catch (const Error& error) {
      if (unwritten_ && unwritten_->frame != frame) finishWriting();  // the previous frame
      if (error.code() == ErrorCode::kExists || frames_.numbers().size() == 1) throw;
      if (error.code() == ErrorCode::kCancelled) throw frames_.interrupted(done_ - result_.statistics.failed.size());
      if (result_.statistics.failed.empty()) result_.first_failure = error.what();
      result_.statistics.failed.push_back(frame);
      listener_.frameFailed(frame, error, ++done_);
    }
  }

  void handle(int frame) {
    progress_.throwIfCancelled("rendering");
    if (resume_ && frames_.isThere(frame)) {
      frames_.removeLeftovers(frame);
      if (checkpoint_) FileSystem::real().removeAll(checkpointOf(job_, frame));
      result_.statistics.kept.push_back(frame);
      listener_.frameKept(job_, frame, ++done_);
    } else {
      draw(frame, frames_.openedFor(frame));
    }
  }

  void draw(int frame, OpenedJob& opened) {
    requirePlaces(job_, frame);
    listener_.frameStarted(frame);
    std::error_code ignored;
    if (const auto tiles = checkpointOf(job_, frame);
        resume_ && !checkpoint_ && std::filesystem::exists(tiles, ignored))
      progress_.note(tiles.string() + " holds finished tiles of a picture; with --checkpoint they are gone on from");
    if (const auto tiles = checkpointOf(job_, frame); checkpoint_)
      tile_locks_.emplace(frame, std::make_unique<FileLock>(lockOf(tiles), refusalOf(tiles)));
    DrawnFrame drawn = checkpoint_ ? drawInTiles(opened, frame, resume_, progress_) : opened.draw(frame, progress_);
    opened.judge(drawn);
    finishWriting();
    if (!opened.writesBehind()) {
      writeFrame(opened.job(), frame, drawn, opened.firstVolume(), opened.memory().files);
      return written(opened, frame, drawn.statistics);
    }
    unwritten_ = std::make_unique<Unwritten>(Unwritten{frame, opened, std::move(drawn)});
    if (!writer_) writer_.emplace("writes");
    writer_->begin([&of = *unwritten_] {
      writeFrame(of.opened.job(), of.frame, of.drawn, of.opened.firstVolume(), of.opened.memory().files);
    });
  }

  // Waits until the previous frame is written. A frame is waited for once: its failure is known after the first wait.
  void finishWriting() {
    const std::unique_ptr<Unwritten> last = std::move(unwritten_);
    if (!last) return;
    attempt(last->frame, [&] {
      writer_->wait();
      written(last->opened, last->frame, last->drawn.statistics);
    });
  }

  void written(const OpenedJob& opened, int frame, const FrameStatistics& statistics) {
    if (checkpoint_) FileSystem::real().removeAll(checkpointOf(opened.job(), frame));
    tile_locks_.erase(frame);
    result_.statistics.add(statistics);
    noteDamage(statistics, progress_);
    listener_.frameDone(job_, statistics, ++done_);
  }

  const RenderJob& job_;
  const bool resume_, checkpoint_;
  Progress& progress_;
  SequenceListener& listener_;
  SequenceFrames frames_;
  std::size_t done_ = 0;
  SequenceResult result_;
  std::map<int, std::unique_ptr<FileLock>> tile_locks_;  // by frame, on checkpoints until the frame's files are written
  std::unique_ptr<Unwritten> unwritten_;
  std::optional<WorkerThread> writer_;  // destroyed first: waits for the files
};

// Each rank has its own clock and trace file: NAME.json is rank 0's, then NAME.1.json.
std::filesystem::path traceOfRank(const std::filesystem::path& trace, const Ranks* ranks) {
  if (ranks == nullptr || ranks->first()) return trace;
  std::filesystem::path of_rank = trace;
  of_rank.replace_extension(std::to_string(ranks->rank()));
  return of_rank += trace.extension();
}

}  // namespace

// A single thread gains nothing by writing behind.
bool writesBehind(const RenderJob& job) {
  return framesOf(job).size() > 1 && !isSeries(job) && ThreadLimit::active() > 1;
}

MemoryBeside besideBytes(const RenderJob& job, const SequenceOptions& options) {
  if (options.ranks == nullptr || options.ranks->alone())
    return options.checkpoint ? checkpointMemory(job) : MemoryBeside();
  return job.distribution == Distribution::kBricks ? partBytes(job) : sharedTileBytes(job);
}

SequenceResult runSequence(const RenderJob& given, const SequenceOptions& options, Progress& progress,
                           SequenceListener& listener) {
  if (filesOf(given, 1).empty()) throw Error(ErrorCode::kUsage, "output: is missing; name the picture to write");
  const ThreadLimit threads(given.speed.threads);
  RenderJob job = given;
  // Precedes the first collective step: messages depend on frames and volumes.
  if (options.ranks != nullptr) requireAgreement(*options.ranks, jobFacts(job, options));
  const bool first = options.ranks == nullptr || options.ranks->first();
  // Another process with the same video would remove the frames kept for the video.
  std::optional<FileLock> video;
  if (const auto path = behindLinks(job.output.video.path); first && !path.empty())
    video.emplace(lockOf(path), refusalOf(path));
  if (!job.series) job.series = seriesLook(job, options.store_for, options.resume, options.ranks);
  if (job.series && first) progress.note(job.series->choice);
  std::optional<Trace> trace;
  if (!job.trace.empty()) trace.emplace(traceOfRank(job.trace, options.ranks));
  SequenceResult result = options.ranks != nullptr && !options.ranks->alone()
                              ? shareSequence(job, options, progress, listener)
                              : Sequence(job, options, progress, listener).run();
  if (trace) trace->finish();
  warnOfDoubtfulFrames(result.statistics.frames, framesOf(job).size() > 1, progress);
  return result;
}

}  // namespace kiln
