// A job whose volumes stay open from frame to frame, so that bricks stay in memory.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "frame/frame_memory.h"
#include "frame/render_frame.h"
#include "frame/statistics.h"
#include "image/image.h"
#include "job/frame/frame_scene.h"
#include "job/render_job.h"
#include "ranks/shared_reads.h"
#include "sequence/opened_volumes.h"

namespace kiln {

struct DrawnView {
  Image image;  // with all planes of the job's files
  View view;
};

struct FrameTiles;

/// A reason to doubt the picture. Volumes with equal doubts cause one warning.
struct Doubt {
  std::string kind, sentence;
};
/// Finds labels without an entry, unknown frames of reference and units, amounts that look like labels, sections that
/// no frame shows.
std::vector<Doubt> doubtsOf(const RenderJob& job, const OpenedVolumes& volumes, const SceneOfJob& scenes);
/// Warns of the doubts whose kinds are not among `doubted`, and adds these kinds.
void warnOf(const std::vector<Doubt>& doubts, std::set<std::string>& doubted, Progress& progress);

struct DrawnFrame {
  std::vector<DrawnView> views;  // one view, or the left and the right eye's
  std::shared_ptr<FrameTiles>
      tiles{};  // if not null, the pixels are here (sequence/frame_checkpoint.h) and not in `views`
  FrameScene scene;
  FrameStatistics statistics;
  bool continued = false;  // an earlier run drew some tiles; times cover all runs, other statistics the last
};

/// Returns the handler of bricks that cannot be read: a warning for each if the job skips damaged bricks, else empty.
/// requires: `progress` outlives the handler.
BrickCache::SkipHandler skipperOf(const RenderJob& job, Progress& progress);

/// Sets the reason for an empty frame. `request` is made of the frame's scene.
void judge(DrawnFrame& drawn, const FrameRequest& request, const OpenedVolumes& volumes);

class OpenedJob {
 public:
  /// All volumes of the job are stores. `beside` is memory of the caller, charged with the image. With `shared`, brick
  /// files are read once among all ranks, if memory is left. With `writes_behind`, the caller keeps a frame while the
  /// next frame is drawn, if memory is left.
  /// requires: `progress` outlives this. throws: Error kUsage, kBudget, kDamaged, kNotFound, kIo.
  OpenedJob(const RenderJob& job, Progress& progress, const MemoryBeside& beside = 0, SharedReads* shared = nullptr,
            bool writes_behind = false);
  /// Draws from volumes of the caller.
  OpenedJob(const RenderJob& job, OpenedVolumes volumes, Progress& progress, const MemoryBeside& beside = 0,
            SharedReads* shared = nullptr, bool writes_behind = false);
  OpenedJob(const OpenedJob&) = delete;
  OpenedJob& operator=(const OpenedJob&) = delete;

  /// Returns the scene of a frame. throws: Error kUsage for a frame that cannot be drawn.
  FrameScene sceneAt(int frame) const { return scenes_.at(frame); }
  /// Draws a frame, reported to `progress` as one step. throws: as renderFrame and sceneAt.
  DrawnFrame draw(int frame, Progress& progress);
  /// Return the request of a frame, and a painter for drawing the frame piece by piece. requires: no other painter
  /// exists.
  FrameRequest requestFor(const FrameScene& scene) const;
  std::unique_ptr<FramePainter> painterFor(const FrameScene& scene, Progress& progress);
  /// Returns the statistics of the pieces.
  FrameStatistics finish(FramePainter& painter, int frame) const;

  /// Returns true if memory is reserved for a finished frame beside the frame being drawn.
  bool writesBehind() const { return memory_.behind > 0; }
  const BrickedVolume& firstVolume() const { return volumes_.first(); }
  /// The job as given to the constructor.
  const RenderJob& job() const { return job_; }
  std::vector<Doubt> doubts() const { return doubtsOf(job_, volumes_, scenes_); }
  /// Sets the reason for an empty frame.
  void judge(DrawnFrame& drawn) const { kiln::judge(drawn, requestFor(drawn.scene), volumes_); }
  /// Notes that a deep picture differs from the flat picture of equal options, unless both are drawn; and that a PNG of
  /// bright fog looks pale on a white page, unless the job has a background.
  void noteLook(Progress& progress) const;
  /// The plan of the job's memory.
  const FrameMemory& memory() const { return memory_; }
  /// Adds the plan and the peak so far to the statistics.
  void describeMemory(RenderStatistics& statistics) const;

 private:
  void noteDeep(Progress& progress) const;
  void notePaleFog(Progress& progress) const;

  const RenderJob job_;
  const RenderJob drawn_job_;  // with the AOVs of all files
  const OpenedVolumes volumes_;
  FitReads fit_;
  SceneOfJob scenes_;
  FrameMemory memory_;
  const OpenedForRanks for_ranks_;
  BrickCache cache_;
  mutable std::shared_ptr<const Illumination> shadows_;  // of the last view
};

/// Draws a frame whose views' requests come from `request_for`; reported to `progress` as one step. `cache` may serve
/// several jobs of the same volumes in turn. throws: as renderFrame.
DrawnFrame drawFrame(BrickCache& cache, const FrameScene& scene,
                     const std::function<FrameRequest(const FrameScene&)>& request_for, int frame, Progress& progress);

/// Threads of a cache that read ahead: none with one thread, so that statistics repeat exactly.
unsigned readersOfCache();
/// Returns the request of a frame that keeps to a plan of memory.
FrameRequest requestOf(const FrameScene& scene, const SpeedOptions& speed, const FrameMemory& memory);

/// Returns what scenes of the job take from its volumes and annotations: all programs that draw or plan the job have
/// equal cameras. Boxes are found by index and bricks of the volumes; what is read is added to `reads`. If the job
/// skips damaged bricks, a damaged brick makes the box larger, with a warning. requires: all outlive the result.
/// throws: Error kUsage for a level that a volume lacks.
SceneInputs sceneInputsOf(const RenderJob& job, const OpenedVolumes& volumes, FitReads& reads, Progress& progress);

/// Plans the memory of the job's first frame, with the samples of the frame that has most. `beside` is charged with the
/// image. throws: as SceneOfJob::at; kCancelled.
FrameMemory memoryOf(RenderJob job, const std::vector<const BrickedVolume*>& stores, const SceneOfJob& scenes,
                     const MemoryBeside& beside, const Progress& progress = Progress());

/// Notes how many bricks are missing from a picture, if any.
void noteDamage(const FrameStatistics& frame, Progress& progress);

/// Returns the planes of one file.
Aovs aovsOf(const RenderJob& job, const OutputFile& file);

/// Returns the planes of all files together, and the depth that hides an outline.
Aovs drawnAovs(const RenderJob& job);

}  // namespace kiln
