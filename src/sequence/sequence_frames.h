// What a sequence is made of, whoever draws which of its frames: their folders, the store of each, which of them are
// there already, and the video.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/progress.h"
#include "sequence/frame_files.h"
#include "sequence/opened_job.h"

namespace kiln {

/// Whether each frame of the job may have a volume of its own.
bool isSeries(const RenderJob& job);
/// The job over the volume of a frame.
RenderJob jobAtFrame(const RenderJob& job, int frame);

/// Renames the job's volume, or each of several.
void forEachVolume(RenderJob& job, const std::function<std::filesystem::path(const std::filesystem::path&)>& change);
/// The names of its volumes.
std::vector<std::filesystem::path> volumesOf(const RenderJob& job);

/// The store for a volume, which may be a foreign file.
using StoreFor = std::function<std::filesystem::path(const std::filesystem::path&)>;

/// What is done of each frame, and how.
struct FramesRole {
  /// It draws this part of each picture; the job's files are of the whole.
  std::optional<VoxelBox> part{};
  SharedReads* shared_reads = nullptr;  // what it reads is read for others, too
  bool warns = true;                    // of what the volumes are
  /// Files of a frame are written while the next is drawn, where memory is left for that.
  bool writes_behind = false;
};

class SequenceFrames {
 public:
  /// `beside` is charged to the memory with the image. requires: the others outlive this. throws: Error kUsage
  /// where the job names no files for its frames.
  SequenceFrames(const RenderJob& job, StoreFor store_for, Progress& progress, const MemoryBeside& beside = 0,
                 FramesRole role = {});

  const std::vector<int>& numbers() const { return numbers_; }
  const RenderJob& job() const { return job_; }
  const StoreFor& stores() const { return store_for_; }
  /// A folder that a frame's number names is ours to make, and so is that of frames kept for a video.
  void makeFolders() const;
  /// What is wrong with a frame is known before the first is drawn. Of a time series it is not.
  void requireScenes();
  /// The frame's store, the only one that is open. throws: as OpenedJob.
  OpenedJob& openedFor(int frame);
  /// Whether all files of a frame are there and whole. throws: Error kExists where one is another job's.
  bool isThere(int frame);
  /// What the frame shows, and the job, as its files say: without the part.
  FrameScene sceneToWrite(const OpenedJob& opened, int frame) const;
  RenderJob jobToWrite(const OpenedJob& opened) const;
  void makeVideo() const;
  /// Of the stores that were open.
  void describeMemory(RenderStatistics& statistics) const;
  /// That says how to go on, where `done` frames are finished.
  Error interrupted(std::optional<std::size_t> done) const;

 private:
  const RenderJob& job_;
  const StoreFor store_for_;
  Progress& progress_;
  const MemoryBeside beside_;
  const FramesRole role_;
  const std::vector<int> numbers_;
  std::vector<std::filesystem::path> volumes_;
  std::unique_ptr<OpenedJob> opened_;
  std::set<std::string> doubted_;  // kinds of doubts that were warned of
  RenderStatistics memory_;
};

}  // namespace kiln
