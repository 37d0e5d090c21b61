// One frame as a list of steps (DESIGN §3): classify, walk the bricks front to back, draw each in parallel tiles, lay
// the result over the background.
#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "frame/statistics.h"
#include "image/image.h"
#include "job/render_job.h"
#include "traverse/brick_walk.h"
#include "traverse/node_log.h"

namespace kiln {

/// How a frame shows one of several volumes.
struct VolumeRequest {
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;
};

/// With so many bricks at a time a thread that has no tile of one has another's: after each set threads wait for the
/// last tile of it, and of four bricks that is up to a tenth of the time.
inline constexpr int kMostBricksTogether = 32;
/// And so many are worth more than room for other things, or than knowing what they hide of the next one.
inline constexpr int kEnoughBricksTogether = 4;

/// What a frame needs beside the volume, every choice made.
struct FrameRequest {
  View view;
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;
  Background background;
  double opacity_threshold = 0.998;
  Mode mode = Mode::kComposite;
  Lattice lattice = Lattice::kPixel;
  Interpolation interpolation = Interpolation::kLinear;
  double sample_distance = kSampleDistance;  // Sampling's
  std::optional<PixelRect> crop;             // these pixels of the whole picture are drawn; else all
  int samples = 1;                           // sub-pixels of a pixel: 1, 2, 4 or 16
  bool filters_rays = true;       // pixels of rays are what PixelFilter makes of them; else means of sub-pixels
  Aovs aovs;                      // what the image has planes of
  std::optional<DeepBound> deep;  // the image has deep samples, too; of light in slabs, samples == 1, unfiltered
  std::optional<int> level;       // of the whole frame; else, for each region, the one whose voxels are pixel-sized
  Sampling sampling() const { return {level, interpolation, sample_distance, samples == 2, samples == 16}; }
  VisibilityOptions visibility;
  int tile_px = 64;                           // as SpeedOptions has it
  int bricks_together = kMostBricksTogether;  // drawn at a time, where several are in memory; no bit depends on it
  int band_px = 1024;  // of sub-pixels: rows drawn at a time, in steps of kVisibilityTile; no bit depends on it
  NodeLog* node_log = nullptr;  // requires: tile_px == 0 and a level
  /// Of several volumes in one picture, each; transfer function, shading and clipping above say nothing then.
  std::vector<VolumeRequest> volumes;
};

/// The view in which a frame of the volume is drawn: a parallel view with its origin near the volume (nearVolume).
/// Slabs of samples are counted from the origin. Several volumes have theirs near the box around all.
View drawnView(const View& view, const VolumeGeometry& volume);

/// The bricks that a frame asks for if nothing hides anything, each once; of a panorama, for each of its faces.
std::vector<StoredBrick> bricksInView(const std::vector<const StoreReader*>& stores, const FrameRequest& request,
                                      BrickWalkCounts& counts);

/// What drawing the frames of a job's eyes counts as it goes on, where they are drawn in several parts (bands of
/// sub-pixels, faces, eyes); 0 where there is one part, which counts for itself. cost: of several parts, their plans.
std::uint64_t stepsOfParts(const std::vector<const StoreReader*>& stores, const std::vector<FrameRequest>& eyes);

/// What of several volumes a frame has in memory at once, at least. unit: bytes.
std::uint64_t leastMixBytes(const std::vector<const StoreReader*>& stores, const FrameRequest& request);

/// Those of one volume, with what of the image of sub-pixels each can touch. requires: no other volumes.
std::vector<BrickInView> bricksOnImage(const StoreReader& store, const FrameRequest& request);

class FrameDrawing;

/// A frame that is drawn piece by piece, in any order; what the pieces cost adds up. No panorama.
class FramePainter {
 public:
  /// requires: all but `request` outlive this; nobody else uses the cache. throws: as renderFrame.
  FramePainter(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress);
  ~FramePainter();
  FramePainter(const FramePainter&) = delete;
  FramePainter& operator=(const FramePainter&) = delete;

  /// These pixels of the whole picture, and their planes. requires: in the crop, none drawn before. throws: as
  /// renderFrame.
  Image draw(const PixelRect& pixels);
  /// What all pieces have cost. The cache reads nothing for them any more.
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
/// `progress` hears how far each part is, one after the other (frame/frame_progress.h).
/// throws: what BrickCache::get throws, Error kCancelled, kUsage (lattice, level, crop, samples, interpolation,
/// distance of samples), kBudget where the cache has no room for the bricks of several volumes that meet in a tile.
Image renderFrame(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress,
                  FrameStatistics& statistics);

}  // namespace kiln
