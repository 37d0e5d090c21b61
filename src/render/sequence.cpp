#include "render/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "base/file.h"
#include "base/parallel.h"
#include "base/trace.h"
#include "render/frame_checkpoint.h"
#include "render/video.h"
#include "scene/frame_list.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> volumesOf(const RenderJob& job) {
  std::vector<fs::path> out;
  for (const VolumeOptions& volume : job.volumes) out.push_back(volume.volume);
  if (out.empty()) out.push_back(job.volume);
  return out;
}

// Whether each frame may have a volume of its own.
bool isSeries(const RenderJob& job) {
  const std::vector<fs::path> volumes = volumesOf(job);
  return std::any_of(volumes.begin(), volumes.end(), hasFramePlace) && (!job.frames.empty() || moves(job));
}

class Sequence {
 public:
  Sequence(const RenderJob& job, const SequenceOptions& options, Progress& progress, SequenceListener& listener)
      : job_(job), options_(options), progress_(progress), listener_(listener), frames_(framesOf(job)) {}

  SequenceResult run() {
    requireOutputs(job_, frames_.size());
    if (options_.checkpoint) requireCheckpoint(job_);
    makeFolders();
    if (!isSeries(job_)) requireScenes();
    listener_.started(job_, frames_);
    for (const int frame : frames_) {
      handle(frame);
      ++done_;
    }
    if (opened_) opened_->describeMemory(result_.statistics);
    if (!job_.output.video.path.empty() && result_.statistics.failed.empty()) makeVideo();
    return std::move(result_);
  }

 private:
  // A folder that a frame's number names is ours to make, and so is that of frames kept for a video.
  void makeFolders() {
    if (!job_.output.video.path.empty() && videoFrameOf(job_, 0).parent_path() == keptFramesOf(job_.output.video))
      FileSystem::real().makeDirectories(keptFramesOf(job_.output.video));
    for (const int frame : frames_) {
      const std::vector<OutputFile> files = filesOf(job_, frame), others = filesOf(job_, frame + 1);
      for (std::size_t i = 0; i < files.size(); ++i) {
        const fs::path folder = files[i].path.parent_path();
        if (folder.empty() || frames_.size() == 1) continue;
        if (others[i].path.parent_path() != folder)
          FileSystem::real().makeDirectories(folder);
        else if (frame == frames_.front() && !fs::is_directory(folder))
          throw Error(ErrorCode::kNotFound, folder, "", "there is no such directory to write the pictures to");
      }
    }
  }

  // What is wrong with a frame is known before the first is drawn.
  void requireScenes() {
    const OpenedJob& opened = openedFor(frames_.front());
    for (const int frame : frames_) {
      try {
        opened.sceneAt(frame);
      } catch (const Error& error) {
        if (frames_.size() == 1) throw;
        throw Error(error.code(), fmt::format("frame {}: {}", frame, error.what()));
      }
    }
  }

  OpenedJob& openedFor(int frame) {
    RenderJob job = jobAtFrame(job_, frame);
    if (opened_ && volumesOf(job) == volumes_) return *opened_;
    volumes_ = volumesOf(job);
    if (opened_) opened_->describeMemory(result_.statistics);
    opened_.reset();  // before the next one takes its memory
    if (options_.store_for) forEachVolume(job, options_.store_for);
    opened_ = std::make_unique<OpenedJob>(job, progress_, options_.checkpoint ? checkpointBytes(job) : 0);
    return *opened_;
  }

  void handle(int frame) {
    try {
      progress_.throwIfCancelled("rendering");
      OpenedJob& opened = openedFor(frame);
      if (options_.resume && isThere(frame, opened)) {
        if (options_.checkpoint) FileSystem::real().removeAll(checkpointOf(job_, frame));
        result_.statistics.kept.push_back(frame);
        listener_.frameKept(job_, frame, done_ + 1);
      } else {
        draw(frame, opened);
      }
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kExists || frames_.size() == 1) throw;
      if (error.code() == ErrorCode::kCancelled) throw interrupted();
      if (result_.statistics.failed.empty()) result_.first_failure = error.what();
      result_.statistics.failed.push_back(frame);
      listener_.frameFailed(frame, error, done_ + 1);
    }
  }

  bool isThere(int frame, const OpenedJob& opened) const {
    const FrameScene scene = opened.sceneAt(frame);
    const RenderJob job = jobAtFrame(job_, frame);
    bool whole = true;
    for (const OutputFile& file : filesOf(job_, frame))
      whole = findFile(job, file, scene, opened.store()) == FoundFile::kWhole && whole;
    return whole;
  }

  void draw(int frame, OpenedJob& opened) {
    listener_.frameStarted(frame);
    DrawnFrame drawn =
        options_.checkpoint ? drawInTiles(opened, frame, options_.resume, progress_) : opened.draw(frame, progress_);
    writeFrame(opened.job(), frame, drawn, opened.store());
    if (options_.checkpoint) FileSystem::real().removeAll(checkpointOf(opened.job(), frame));
    result_.statistics.add(drawn.statistics);
    noteDamage(drawn.statistics, progress_);
    listener_.frameDone(job_, drawn.statistics, done_ + 1);
  }

  Error interrupted() const {
    return Error(ErrorCode::kCancelled,
                 fmt::format("interrupted: {} of {} frames are there and stay; the same command with --resume goes on",
                             done_ - result_.statistics.failed.size(), frames_.size()));
  }

  void makeVideo() {
    std::vector<fs::path> pictures;
    for (const int frame : frames_) pictures.push_back(videoFrameOf(job_, frame));
    const VideoOptions& video = job_.output.video;
    writeVideo(pictures, video, progress_);
    const fs::path kept = keptFramesOf(video);
    if (pictures.front().parent_path() == kept) FileSystem::real().removeAll(kept);
  }

  const RenderJob& job_;
  const SequenceOptions& options_;
  Progress& progress_;
  SequenceListener& listener_;
  const std::vector<int> frames_;
  std::size_t done_ = 0;
  SequenceResult result_;
  std::vector<fs::path> volumes_;
  std::unique_ptr<OpenedJob> opened_;
};

}  // namespace

RenderJob jobAtFrame(const RenderJob& job, int frame) {
  RenderJob out = job;
  if (isSeries(job)) forEachVolume(out, [&](const fs::path& volume) { return pathOfFrame(volume, frame); });
  return out;
}

void forEachVolume(RenderJob& job, const std::function<fs::path(const fs::path&)>& change) {
  for (VolumeOptions& volume : job.volumes) volume.volume = change(volume.volume);
  job.volume = job.volumes.empty() ? change(job.volume) : job.volumes.front().volume;
}

SequenceResult runSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                           SequenceListener& listener) {
  const ThreadLimit threads(job.speed.threads);
  std::optional<Trace> trace;
  if (!job.trace.empty()) trace.emplace(job.trace);
  SequenceResult result = Sequence(job, options, progress, listener).run();
  if (trace) trace->finish();
  return result;
}

}  // namespace kiln
