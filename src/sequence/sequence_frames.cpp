#include "sequence/sequence_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/file/file.h"
#include "base/file/path_status.h"
#include "base/file/temporary_file.h"
#include "base/hash.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "sequence/frame_annotations.h"
#include "sequence/video.h"

namespace kiln {
namespace fs = std::filesystem;

bool isSeries(const RenderJob& job) {
  const std::vector<fs::path> volumes = inputVolumesOf(job);
  return std::any_of(volumes.begin(), volumes.end(), hasFramePlace) && (!job.frames.empty() || moves(job));
}

RenderJob jobAtFrame(const RenderJob& job, int frame) {
  RenderJob out = job;
  if (isSeries(job)) forEachVolume(out, [&](const fs::path& volume) { return pathOfFrame(volume, frame); });
  return out;
}

SequenceFrames::SequenceFrames(const RenderJob& job, StoreFor store_for, Progress& progress, const MemoryBeside& beside,
                               FramesRole role)
    : job_(job),
      store_for_(std::move(store_for)),
      progress_(progress),
      beside_(beside),
      role_(role),
      numbers_(framesOf(job)) {
  requireFont(job_);
  if (role_.has_files) requireOutputs(job_, numbers_);
}

void SequenceFrames::makeFolders() const {
  if (!job_.output.video.path.empty()) FileSystem::real().requirePlaceToRename(job_.output.video.path);
  if (keepsFramesForVideo(job_)) FileSystem::real().makeDirectories(keptFramesOf(job_.output.video));
  for (const int frame : numbers_) {
    const std::vector<OutputFile> files = filesOf(job_, frame), others = filesOf(job_, frame + 1);
    for (std::size_t i = 0; i < files.size(); ++i) {
      const fs::path folder = files[i].path.parent_path();
      if (folder.empty() || numbers_.size() == 1) continue;
      if (others[i].path.parent_path() != folder)
        FileSystem::real().makeDirectories(folder);
      else if (frame == numbers_.front() && !isFolder(folder))
        throw Error(ErrorCode::kNotFound, folder, "", "there is no such directory to write the pictures to");
    }
  }
}

void SequenceFrames::requireScenes() {
  if (isSeries(job_)) return;
  const OpenedJob& opened = openedFor(numbers_.front());
  for (const int frame : numbers_) {
    try {
      opened.sceneAt(frame);
    } catch (const Error& error) {
      if (numbers_.size() == 1) throw;
      throw Error(error.code(), fmt::format("frame {}: {}", frame, error.what()));
    }
  }
}

OpenedJob& SequenceFrames::openedFor(int frame) {
  RenderJob job = jobAtFrame(job_, frame);
  if (opened_ && inputVolumesOf(job) == volumes_) return *opened_;
  volumes_ = inputVolumesOf(job);
  if (opened_) opened_->describeMemory(memory_);
  opened_.reset();  // frees memory before the next job opens
  if (store_for_) forEachVolume(job, store_for_);
  if (role_.part) job.picture.clipping.part = role_.part;
  opened_ = std::make_unique<OpenedJob>(job, progress_, beside_, role_.shared_reads, role_.writes_behind);
  if (!role_.warns) return *opened_;
  if (frame == numbers_.front() && !std::exchange(look_noted_, true)) opened_->noteLook(progress_);
  warnOf(opened_->doubts(), doubted_, progress_);
  return *opened_;
}

bool SequenceFrames::isThere(int frame) {
  if (areInVideo()) return true;
  const OpenedJob& opened = openedFor(frame);
  const FrameScene scene = sceneToWrite(opened, frame);
  const RenderJob job = jobAtFrame(job_, frame);
  bool whole = true;
  for (const OutputFile& file : filesOf(job_, frame))
    whole = findFile(job, file, scene, opened.firstVolume()) == FoundFile::kWhole && whole;
  return whole;
}

void SequenceFrames::removeLeftovers(int frame) const {
  for (const OutputFile& file : filesOf(job_, frame)) TemporaryFile::removeLeftovers(behindLinks(file.path));
}

FrameScene SequenceFrames::sceneToWrite(const OpenedJob& opened, int frame) const {
  FrameScene scene = opened.sceneAt(frame);
  if (role_.part) scene.picture.clipping.part.reset();
  return scene;
}

RenderJob SequenceFrames::jobToWrite(const OpenedJob& opened) const {
  RenderJob job = opened.job();
  if (!role_.part) return job;
  job.picture.clipping.part.reset();
  job.volume = job_.volume;  // headers name the whole store, even if the rank reads a part
  return job;
}

// Returns a hash of all that the frames depend on; nothing where damaged bricks may be missing, so that no run keeps
// such a video. The volumes of a series are opened once for it.
std::string SequenceFrames::videoRecord() {
  if (job_.picture.skip_damaged || !video_record_.empty()) return video_record_;
  std::string frames = job_.output.video.rate.text();
  for (const int frame : numbers_) {
    const OpenedJob& opened = openedFor(frame);
    frames += "\n" + contentHash(jobAtFrame(job_, frame), videoFrameOf(job_, frame), sceneToWrite(opened, frame),
                                 opened.firstVolume().manifest());
  }
  return video_record_ = std::string(kVideoRecord) + toHex(hashOf(std::string_view(frames)));
}

// A frame whose volume cannot be opened is reported when it is drawn.
void SequenceFrames::findVideo() {
  const VideoOptions& video = job_.output.video;
  if (video.path.empty() || !kiln::isThere(video.path)) return;
  try {
    video_there_ = isVideoOf(video, videoRecord(), progress_);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled) throw interrupted(0);
    if (error.code() == ErrorCode::kExists) throw;
  }
}

void SequenceFrames::makeVideo() {
  const VideoOptions& video = job_.output.video;
  if (video.path.empty()) return;
  std::vector<fs::path> pictures;
  for (const int frame : numbers_) pictures.push_back(videoFrameOf(job_, frame).path);
  if (!video_there_) writeVideo(pictures, video, videoRecord(), job_.speed.memory_bytes, progress_);
  if (!keepsFramesForVideo(job_)) return;
  // Also removes the folder, unless it holds other files.
  for (const fs::path& picture : pictures) FileSystem::real().removeAll(picture);
  std::error_code not_empty;
  fs::remove(keptFramesOf(video), not_empty);
}

void SequenceFrames::describeMemory(RenderStatistics& statistics) const {
  statistics.peak_cache_bytes = memory_.peak_cache_bytes;
  if (opened_) opened_->describeMemory(statistics);
}

Error SequenceFrames::interrupted(std::optional<std::size_t> done) const {
  return Error(ErrorCode::kCancelled,
               fmt::format("interrupted: {} are there and stay; the same command with --resume goes on",
                           done ? fmt::format("{} of {} frames", *done, numbers_.size()) : "finished frames"));
}

}  // namespace kiln
