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

/// The view in which a frame of the volume is drawn: a parallel view with its origin near the volume (nearVolume).
/// Slabs of samples are counted from the origin. Several volumes have theirs near the box around all.
View drawnView(const View& view, const VolumeGeometry& volume);

/// The bricks that a frame asks for if nothing hides anything, each once; of a panorama, for each of its faces.
std::vector<StoredBrick> bricksInView(const std::vector<const StoreReader*>& stores, const FrameRequest& request,
                                      BrickWalkCounts& counts);

/// Returns the total of the progress of a frame that is drawn in several parts (bands of sub-pixels, faces, eyes); 0
/// for a single part, which knows its own total. cost: the plans of the parts.
std::uint64_t stepsOfParts(const std::vector<const StoreReader*>& stores, const std::vector<FrameRequest>& eyes);

/// Returns the memory of bricks that must be in the cache at once, beyond the largest brick: the bricks of several
/// volumes that meet in a tile. unit: bytes.
std::uint64_t bytesAtOnce(const std::vector<const StoreReader*>& stores, const FrameRequest& request);

/// Returns the bricks of one volume, with the pixels of the image of sub-pixels that each can touch. requires: no other
/// volumes.
std::vector<BrickOfFrame> bricksOnImage(const StoreReader& store, const FrameRequest& request);

class FrameDrawing;

/// A frame that is drawn piece by piece, in any order; what the pieces cost adds up. No panorama.
class FramePainter {
 public:
  /// requires: all but `request` outlive this; nobody else uses the cache. throws: as renderFrame.
  FramePainter(BrickCache& cache, const FrameRequest& request, Progress& progress);
  ~FramePainter();
  FramePainter(const FramePainter&) = delete;
  FramePainter& operator=(const FramePainter&) = delete;

  /// These pixels of the whole picture, and their planes. requires: in the crop, none drawn before. throws: as
  /// renderFrame.
  Image draw(const PixelRect& pixels);
  /// Returns the statistics of all pieces, and ends reading ahead.
  FrameStatistics finish();

 private:
  const FrameRequest request_, of_sub_pixels_;
  void count(std::chrono::steady_clock::time_point begin, const BusyTimes& before);
  FrameStatistics cost_;  // time and visibility of all pieces so far
  std::unique_ptr<FrameDrawing> drawing_;
};

/// Draws one frame: an image of the crop's size, each pixel of which is that of the whole picture, bit for bit, but for
/// the quadtree, and its planes the same. The picture depends neither on the cache's budget, the threads, the tiles nor
/// on an exact visibility method; where the level is named, nor on the bricks' size. With one tile for the frame it is
/// Lee and Ihm's algorithm to the letter: one sequential walk, every node tested with all of its projected area. A
/// brick that the cache skips is drawn as nothing. Of several volumes, `store` is the first and the cache is of all.
/// `progress` hears how far each part is, one after the other (frame/pass/frame_progress.h).
/// throws: what BrickCache::get throws, Error kCancelled, kUsage (lattice, level, crop, samples, interpolation,
/// distance of samples), kBudget where the cache has no room for the bricks of several volumes that meet in a tile.
Image renderFrame(BrickCache& cache, const FrameRequest& request, Progress& progress, FrameStatistics& statistics);

}  // namespace kiln
