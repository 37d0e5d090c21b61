// A job over a volume, or several in one picture, that stay open from frame to frame, so that bricks stay in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "frame/frame_memory.h"
#include "frame/render_frame.h"
#include "frame/statistics.h"
#include "image/image.h"
#include "job/frame_scene.h"
#include "job/render_job.h"
#include "ranks/shared_reads.h"
#include "store/store_reader.h"

namespace kiln {

struct DrawnView {
  Image image;  // with the planes that any of the job's files holds
  View view;
};

struct FrameTiles;

struct DrawnFrame {
  std::vector<DrawnView> views;  // one, or the left eye's and the right eye's
  std::shared_ptr<FrameTiles>
      tiles{};  // if given, they hold the pixels (sequence/frame_checkpoint.h), and no view does
  FrameScene scene;
  FrameStatistics statistics;
  bool continued = false;  // parts of it were drawn by an earlier run: statistics are of the rest
};

class OpenedJob {
 public:
  /// `job.volume` is a store; of several volumes, each is. `beside` are the caller's, charged with the image.
  /// requires: `progress` outlives this. throws: Error kUsage, kBudget, kDamaged, kNotFound, kIo.
  /// With `shared`, brick files are read once among all ranks, where memory is left for it. With `writes_behind`, the
  /// caller keeps a frame while it draws the next, where memory is left for that.
  OpenedJob(const RenderJob& job, Progress& progress, const MemoryBeside& beside = 0, SharedReads* shared = nullptr,
            bool writes_behind = false);
  OpenedJob(const OpenedJob&) = delete;
  OpenedJob& operator=(const OpenedJob&) = delete;

  /// What the frame shows. throws: Error kUsage where it cannot be drawn.
  FrameScene sceneAt(int frame) const { return scenes_.at(frame); }
  /// `progress` hears of one step, how far the frame is. throws: as renderFrame, and sceneAt.
  DrawnFrame draw(int frame, Progress& progress);
  /// What the frame needs, and a painter that draws it piece by piece. requires: no other one is there.
  FrameRequest requestFor(const FrameScene& scene) const;
  std::unique_ptr<FramePainter> painterFor(const FrameScene& scene, Progress& progress);
  /// What the pieces have cost.
  FrameStatistics finish(FramePainter& painter, int frame) const;

  /// Whether memory is set aside for a frame that is kept while the next is drawn.
  bool writesBehind() const { return memory_.behind > 0; }
  /// Of several volumes, the first.
  const StoreReader& store() const { return *stores_.front(); }
  /// As it was given.
  const RenderJob& job() const { return job_; }
  /// A doubt whether the picture is what was asked for, to be warned of once where several volumes have the same.
  struct Doubt {
    std::string kind, sentence;
  };
  /// Labels that are there and have no entry; frames and units that are unknown; amounts that look like labels.
  std::vector<Doubt> doubts() const;
  /// Sets why the frame shows nothing, if it does.
  void judge(DrawnFrame& drawn) const;
  /// Notes that a deep picture is not the flat picture of the same options, unless a flat one is drawn beside it.
  void noteDeep(Progress& progress) const;
  /// What the memory is for.
  const FrameMemory& memory() const { return memory_; }
  /// The same as statistics, and the most that was taken of it so far.
  void describeMemory(RenderStatistics& statistics) const;

 private:
  const RenderJob job_;
  const RenderJob drawn_job_;  // its AOVs are all that any file holds
  const std::vector<std::unique_ptr<StoreReader>> stores_;
  SceneOfJob scenes_;
  FrameMemory memory_;
  const OpenedForRanks for_ranks_;
  BrickCache cache_;
};

/// The job's stores: of several volumes, each. throws: as StoreReader.
std::vector<std::unique_ptr<StoreReader>> storesOf(const RenderJob& job);
std::vector<const StoreReader*> readersOf(const std::vector<std::unique_ptr<StoreReader>>& stores);
std::vector<const Manifest*> manifestsOf(const std::vector<std::unique_ptr<StoreReader>>& stores);

/// The frame and unit of the job's picture: those of its series, or else the first known ones of these volumes.
VolumeGeometry worldOf(const RenderJob& job, const std::vector<const Manifest*>& manifests);

/// What drawing the job's first frame takes, with as many samples as any of them has; `beside` is charged with
/// the image. throws: as SceneOfJob::at.
FrameMemory memoryOf(RenderJob job, const std::vector<const StoreReader*>& stores, const SceneOfJob& scenes,
                     const MemoryBeside& beside);

/// Says how many bricks are missing from a picture, if any.
void noteDamage(const FrameStatistics& frame, Progress& progress);

/// The planes that a file of the job's holds.
Aovs aovsOf(const RenderJob& job, const OutputFile& file);

/// What is drawn beside colours so that each of the job's files has what it holds.
Aovs drawnAovs(const RenderJob& job);

}  // namespace kiln
