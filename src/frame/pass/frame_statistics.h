// The cost of one frame.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "base/thread/busy_times.h"
#include "grid/coords.h"
#include "store/bricked_volume.h"

namespace kiln {

/// The part of a frame at one level; `add` counts one brick.
struct LevelStatistics {
  std::uint64_t bricks = 0, voxels_visited = 0, voxels_splats = 0;
  void add(std::uint64_t visited, std::uint64_t splats) {
    ++bricks;
    voxels_visited += visited;
    voxels_splats += splats;
  }
};

/// The reason for an empty frame.
/// - kOpacity: the transfer function is transparent everywhere.
/// - kValues: the function shows no value of the volume.
/// - kClipped: the region, the box of the world or the planes leave nothing.
/// - kBehind: the volume is behind the eye.
/// - kOutOfView: the volume is beside the picture, or beside its crop.
/// - kTooSmall: the volume covers so little of a pixel that 8 bits round its alpha to 0.
/// - kThin: the region, the box of the world or the planes leave so little that 8 bits round its alpha to 0.
/// - kFaint: 8 bits round the alpha of each pixel to 0.
/// - kCombined: several reasons together: visible values are clipped away, out of view or in no voxel.
/// - kMasked: as kCombined, where a mask may hide the visible values, too.
/// - kDamaged: damaged bricks are missing, and the other bricks show nothing.
enum class EmptyFrame : std::uint8_t {
  kShows,
  kOpacity,
  kValues,
  kClipped,
  kBehind,
  kOutOfView,
  kTooSmall,
  kThin,
  kFaint,
  kCombined,
  kMasked,
  kDamaged
};

/// Counts of one frame. Bricks belong to the levels that the view selects (BrickWalkCounts). With several samples a
/// pixel, the counts refer to the picture of sub-pixels, drawn in bands of rows. Voxels, nodes, hidden bricks and
/// levels are sums over bands, so a brick in two bands counts twice. Voxels, nodes and bricks read include what shadow
/// maps and ambient occlusion need; total, interesting, masked and hidden bricks and the levels are the picture's.
/// Bricks read count twice if the cache could not keep a brick between bands. Total, interesting, contributing and
/// damaged bricks count once.
struct FrameStatistics {
  int frame = 1;         // number of the frame
  unsigned samples = 1;  // per pixel
  EmptyFrame empty = EmptyFrame::kShows;
  bool visible = false;     // 8 bits round the alpha of some pixel above 0, before the background
  bool one_colour = false;  // all values of a volume lie beside its transfer function
  double wall_s = 0, load_s = 0, output_s = 0;
  std::uint64_t voxels_visited = 0, voxels_splats = 0;
  std::uint64_t nodes_tested = 0, nodes_hidden = 0;
  std::uint64_t bricks_total = 0, bricks_interesting = 0, bricks_read = 0, bricks_hidden = 0, bricks_unused = 0,
                bricks_damaged = 0, bricks_read_bytes = 0;
  /// Bricks that a mask hides by its index, and bricks whose mask was read and shows nothing: none is read.
  std::uint64_t bricks_masked = 0, bricks_emptied = 0;
  std::uint64_t companion_reads = 0, companion_bytes = 0;  // bricks read of masks and colours, and their files
  /// With several ranks: bricks served from a rank's memory because two ranks, or one rank twice, needed the brick.
  std::uint64_t bricks_shared = 0, bricks_shared_bytes = 0;
  /// Bricks that change a pixel, and the size of their files: the least that a frame reads.
  std::uint64_t bricks_contributing = 0, bricks_contributing_bytes = 0;
  std::uint64_t slab_bytes = 0;                            // peak of the scratch memory of threads
  std::uint64_t peak_cache_bytes = 0, peak_rss_bytes = 0;  // including earlier frames
  std::vector<LevelStatistics> levels;                     // by level of the store, 0 first
  unsigned threads = 1;                                    // threads that draw; if several, as many more threads read
  BusyTimes busy;                                          // processor times within wall_s
  /// Busy time over the drawing threads' time; above 1 if readers have cores of their own.
  double utilisation() const { return wall_s > 0 ? busy.total() / (wall_s * threads) : 0; }
  std::map<StoredBrick, std::uint64_t> contributing;  // size of the files
  std::set<StoredBrick> damaged;
  void addContributing(const StoredBrick& brick, std::uint64_t file_bytes);
  /// Adds parts of the frame drawn elsewhere, except `frame`, `empty`, `one_colour`, `wall_s` and `output_s`.
  void merge(const FrameStatistics& other);
  /// Adds another view of the frame, drawn later.
  void addView(const FrameStatistics& view);
  /// Adds the cost of shadow maps and ambient occlusion: all but the numbers of bricks and levels in the picture.
  void addLights(const FrameStatistics& lights);
  /// True if a voxel or a sample was drawn into the picture.
  bool draws() const;
};

}  // namespace kiln
