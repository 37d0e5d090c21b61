// Draws the pictures of a session from one cache: previews that are fast, and the picture that `kiln render` draws.
// Method. A preview has one ray a pixel, samples one voxel apart, and the shadows that earlier pictures have drawn.
// While the camera moves, it has as many pixels as the measured cost allows, and levels so coarse that little is read.
// Invariant. Bricks, index, pictures and shadows together keep to the memory of the session's job.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "frame/frame_memory.h"
#include "job/frame/frame_scene.h"
#include "sequence/opened_job.h"
#include "sequence/opened_volumes.h"

namespace kiln {

/// The side of the largest picture. unit: pixels.
inline constexpr int kLargestViewSide = 4096;

/// A job that is ready to be drawn.
struct ViewedJob {
  RenderJob job;
  std::unique_ptr<SceneOfJob> scenes;
  int frame = 1;
  FrameScene scene;  // the frame's
  FrameMemory memory;
};

struct ViewPicture {
  std::vector<std::byte> bytes;
  std::string type;  // "image/jpeg", "image/png"
  int width = 0, height = 0;
  FrameStatistics statistics;
  double seconds = 0;  // to draw and to encode
};

/// thread: one caller at a time.
class ViewPainter {
 public:
  /// Opens the volumes of the job, which are stores. `job` outlives the object. throws: as OpenedJob.
  ViewPainter(const RenderJob& job, Progress& progress) : ViewPainter(job, OpenedVolumes(job), progress) {}
  /// Draws volumes of the caller.
  ViewPainter(const RenderJob& job, OpenedVolumes volumes, Progress& progress);

  const OpenedVolumes& volumes() const { return volumes_; }
  /// Makes every choice of the job's first frame, or of another. throws: Error kUsage, kBudget, kCancelled; as
  /// SceneOfJob.
  std::unique_ptr<ViewedJob> prepare(const RenderJob& job, const Progress& progress);
  /// Makes the choices of all frames. throws: as `prepare`, for the first frame that cannot be drawn; kCancelled.
  void requireDrawable(const RenderJob& job, const Progress& progress);

  /// Leaves the memory of the job's pictures free. throws: Error kBudget.
  void makeRoom(const ViewedJob& job);
  /// Draws a preview that takes about 30 ms.
  ViewPicture moving(const ViewedJob& job, const Progress& progress);
  /// Draws a preview of all pixels, `coarser` levels coarser than the finished picture.
  ViewPicture refined(const ViewedJob& job, int coarser, const Progress& progress);
  /// Returns the reasons to doubt pictures of the job.
  std::vector<Doubt> doubts(const ViewedJob& job) const { return doubtsOf(job.job, volumes_, *job.scenes); }
  /// Draws the frame as `kiln render` does.
  DrawnFrame exact(const ViewedJob& job, Progress& progress);
  /// Returns the PNG of an exact frame.
  ViewPicture png(const ViewedJob& job, DrawnFrame drawn, const Progress& progress);
  /// Returns the levels by which a refined picture must be coarser to read little, 0 if all is in memory.
  int coarserToReadLittle(const ViewedJob& job, const Progress& progress);
  /// Returns the likely time of `exact` for a picture of this size; infinite if no picture was drawn yet. unit:
  /// seconds.
  double exactSeconds(const ImageSize& size) const;
  /// Returns the likely time of all frames; infinite if no picture of such a job was drawn. unit: seconds.
  double renderSeconds(const ViewedJob& job) const;

  /// Returns a brick from the cache or the disk; null if it is damaged and the session skips such bricks.
  std::shared_ptr<const BrickBlock> brick(const StoredBrick& brick) { return cache_.get(brick); }
  CacheCounts counts() const { return cache_.counts(); }

 private:
  FrameRequest previewOf(const ViewedJob& job, const ImageSize& size, int coarser, FrameScene& scene) const;
  ViewPicture draw(const ViewedJob& job, const ImageSize& size, int coarser, bool filtered, const Progress& progress);
  int coarserWithin(const ViewedJob& job, const ImageSize& size, std::uint64_t bytes, const Progress& progress) const;

  const RenderJob& session_;
  const OpenedVolumes volumes_;
  const std::uint64_t bricks_bytes_;  // memory of the cache without any picture
  BrickCache cache_;
  BrickCache::Aside pictures_;  // memory of the job's pictures, shadows and index
  FitReads fit_;
  std::shared_ptr<const Illumination> shadows_;
  double moving_pixels_ = 0;  // of the next preview; 0: not known yet
  int moving_coarser_ = 0;    // levels by which the next preview is coarser
  double exact_pixel_s_ = 0;  // measured; 0: not yet
  std::string exact_cost_;    // of the measured job; its camera and size may differ

  struct ShownMemo {
    std::size_t volume = 0;
    std::vector<TransferFunction> functions;
    Clipping clipping;
    FramedBox box;
  };
  std::vector<ShownMemo> shown_;
  std::string planned_;  // the job of the last plan of memory, without its camera
  FrameMemory plan_;
};

}  // namespace kiln
