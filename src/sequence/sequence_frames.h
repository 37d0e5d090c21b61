// The frames of a sequence, independent of their distribution: folders, stores, finished frames, the video.
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

/// Returns true if each frame of the job may have a volume of its own.
bool isSeries(const RenderJob& job);
/// Returns the job with the volumes of one frame.
RenderJob jobAtFrame(const RenderJob& job, int frame);

/// Returns the store of a volume; converts a foreign file.
using StoreFor = std::function<std::filesystem::path(const std::filesystem::path&)>;

/// A process's share of each frame, and its way of writing.
struct FramesRole {
  /// The drawn box of the volume; the job's files show the whole volume.
  std::optional<VoxelBox> part{};
  SharedReads* shared_reads = nullptr;  // null: no shared reads
  bool warns = true;                    // print doubts about the volumes
  /// Write the files of a frame while the next frame is drawn, if memory is left.
  bool writes_behind = false;
  /// The frames become files; else pictures in memory, and the job's names of files are not tested.
  bool has_files = true;
};

class SequenceFrames {
 public:
  /// `beside` is charged with the image. requires: `job` and `progress` outlive the object. throws: Error kUsage for a
  /// job without files.
  SequenceFrames(const RenderJob& job, StoreFor store_for, Progress& progress, const MemoryBeside& beside = 0,
                 FramesRole role = {});

  const std::vector<int>& numbers() const { return numbers_; }
  const RenderJob& job() const { return job_; }
  const StoreFor& stores() const { return store_for_; }
  /// Makes folders whose names contain the frame number, and the folder of frames kept for a video.
  void makeFolders() const;
  /// Tests the scenes of all frames before the first is drawn; the frames of a time series are not tested.
  void requireScenes();
  /// Opens the job over the frame's stores and closes any other. throws: as OpenedJob.
  OpenedJob& openedFor(int frame);
  /// Returns true if all files of a frame exist and are whole, or the frame is in the video that was found. throws:
  /// Error kExists if another job wrote a file.
  bool isThere(int frame);
  /// Removes the temporary files of killed runs beside a frame's files, as drawing the frame does.
  void removeLeftovers(int frame) const;
  /// Return scene and job for the headers of files: without the part.
  FrameScene sceneToWrite(const OpenedJob& opened, int frame) const;
  RenderJob jobToWrite(const OpenedJob& opened) const;
  /// Looks for a whole video of these frames, which an earlier run made. throws: Error kExists for the video of another
  /// job; kCancelled.
  void findVideo();
  /// Returns whether the frames have no other files, and findVideo has found their video.
  bool areInVideo() const { return video_there_ && keepsFramesForVideo(job_); }
  /// Makes the job's video of the frames' files, unless it was found, and removes frames that were kept for it alone.
  void makeVideo();
  /// Adds the memory of all stores opened so far.
  void describeMemory(RenderStatistics& statistics) const;
  /// Returns the error of an interrupt, with the way to resume after `done` finished frames.
  Error interrupted(std::optional<std::size_t> done) const;

 private:
  std::string videoRecord();
  const RenderJob& job_;
  const StoreFor store_for_;
  Progress& progress_;
  const MemoryBeside beside_;
  const FramesRole role_;
  const std::vector<int> numbers_;
  std::vector<std::filesystem::path> volumes_;
  std::unique_ptr<OpenedJob> opened_;
  bool look_noted_ = false;
  std::string video_record_;  // once it is known
  bool video_there_ = false;
  std::set<std::string> doubted_;  // kinds of doubts already warned about
  RenderStatistics memory_;
};

}  // namespace kiln
