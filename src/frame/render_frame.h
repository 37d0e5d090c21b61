// One frame as a list of steps: classify, walk the bricks front to back, draw each in parallel tiles, lay
// the result over the background.
#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "frame/pass/frame_pass.h"
#include "frame/pass/frame_request.h"
#include "frame/statistics.h"
#include "image/image.h"
#include "job/render_job.h"
#include "traverse/brick_walk.h"

namespace kiln {

/// Returns the view in which a frame of the volume is drawn: a parallel view gets an origin near the volume
/// (nearVolume). Slabs of samples are counted from the origin. With several volumes the origin is near the box around
/// all volumes.
View drawnView(const View& view, const VolumeGeometry& volume);

/// Returns the bricks that a frame reads if nothing is hidden, each once; in a panorama, once per face.
std::vector<StoredBrick> bricksInView(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request,
                                      BrickWalkCounts& counts);

/// Returns the total progress of a frame in several parts (bands of sub-pixels, faces, eyes). Returns 0 for a single
/// part, because the part computes its total. cost: the plans of the parts.
std::uint64_t stepsOfParts(const std::vector<const BrickedVolume*>& stores, const std::vector<FrameRequest>& eyes);

/// Returns the memory for bricks that must be in the cache together, beyond the largest brick: the bricks of several
/// volumes in a tile. unit: bytes.
std::uint64_t bytesAtOnce(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request);

/// Returns the bricks of one volume, each with the sub-pixels that the brick can touch. requires: no other volumes.
std::vector<BrickOfFrame> bricksOnImage(const BrickedVolume& store, const FrameRequest& request);

class FrameDrawing;

/// Draws a frame piece by piece, in any order, and sums the costs of the pieces. No panorama.
class FramePainter {
 public:
  /// requires: all arguments but `request` outlive the object; no other user of the cache. throws: as renderFrame.
  FramePainter(BrickCache& cache, const FrameRequest& request, Progress& progress);
  ~FramePainter();
  FramePainter(const FramePainter&) = delete;
  FramePainter& operator=(const FramePainter&) = delete;

  /// Returns pixels of the whole picture, with planes. requires: the pixels lie in the crop and are drawn once. throws:
  /// as renderFrame.
  Image draw(const PixelRect& pixels);
  /// The times of all pieces so far, and of the plan. unit: seconds.
  double wallSeconds() const { return cost_.wall_s; }
  const BusyTimes& busy() const { return cost_.busy; }
  /// Returns the statistics of all pieces, and ends reading ahead.
  FrameStatistics finish();

 private:
  /// Begins and ends the drawing of a view.
  void beginView(const FrameRequest& eye);
  void endView();
  Image drawView(const PixelRect& pixels);
  Image drawThroughLens(const PixelRect& pixels);
  void count(std::chrono::steady_clock::time_point begin, const BusyTimes& before);

  BrickCache& cache_;
  Progress& progress_;
  FrameRequest request_, of_sub_pixels_;
  FrameStatistics cost_;    // time and visibility of all pieces so far
  FrameStatistics lights_;  // counts of the lights' views
  FrameStatistics drawn_;   // counts of the views that are drawn to their end
  std::unique_ptr<FrameDrawing> drawing_;
};

/// Draws one frame: an image of the crop's size. Except with the quadtree, pixels and planes equal the whole picture's
/// bit for bit, and do not depend on the cache's budget, threads, tiles or an exact visibility method; at a fixed
/// level, not on the size of bricks either.
/// With one tile for the frame the method is exactly Lee and Ihm's: one sequential walk that tests every node with its
/// whole projected area.
/// A brick that the cache skips is drawn as empty. With several volumes, `store` is the first volume and the cache
/// holds all. `progress` gets the parts in turn (frame/pass/frame_progress.h).
/// throws: as BrickCache::get; Error kCancelled; kUsage (lattice, level, crop, samples, interpolation, distance of
/// samples); kBudget if the cache has no room for the bricks of several volumes in a tile.
Image renderFrame(BrickCache& cache, const FrameRequest& request, Progress& progress, FrameStatistics& statistics);

}  // namespace kiln
