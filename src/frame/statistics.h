// What a render cost, as `--stats` writes it.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/thread/profile_scope.h"
#include "cache/brick_cache.h"

namespace kiln {

/// What a frame drew of one level; `add` is told of each brick.
struct LevelStatistics {
  std::uint64_t bricks = 0, voxels_visited = 0, voxels_splats = 0;
  void add(std::uint64_t visited, std::uint64_t splats) {
    ++bricks;
    voxels_visited += visited;
    voxels_splats += splats;
  }
};

/// Why a frame shows nothing.
/// - kOpacity: the transfer function is transparent everywhere.
/// - kValues: the values that the function shows are none of the volume's.
/// - kClipped: the region, the box of the world or the planes leave nothing.
/// - kBehind: the volume is behind the eye.
/// - kOutOfView: the volume is beside the picture, or beside its crop.
/// - kTooSmall: the volume covers so little of a pixel that 8 bits round its alpha to 0.
/// - kThin: the region, the box of the world or the planes leave so little that 8 bits round its alpha to 0.
/// - kFaint: 8 bits round the alpha of each pixel to 0.
/// - kCombined: none of these by itself: what the function shows is clipped away, out of view or in no voxel.
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
  kCombined
};

/// Bricks are those of the levels that the view asks for: `BrickWalkCounts` says which count. Where a pixel is several
/// samples, the sub-pixels' picture is what is counted, and it is drawn in bands of rows, as a crop of rays is: voxels,
/// nodes, bricks hidden and what levels say are sums over the bands, so that a brick in two of them counts in both;
/// bricks read are, where the cache had no room to keep them. Bricks in total, interesting, contributing and damaged
/// count once.
struct FrameStatistics {
  int frame = 1;         // its number
  unsigned samples = 1;  // a pixel
  EmptyFrame empty = EmptyFrame::kShows;
  bool visible = false;     // before the background, an alpha is above those that 8 bits round to 0
  bool one_colour = false;  // all values of a volume lie beside its transfer function
  double wall_s = 0, load_s = 0, output_s = 0;
  std::uint64_t voxels_visited = 0, voxels_splats = 0;
  std::uint64_t nodes_tested = 0, nodes_hidden = 0;
  std::uint64_t bricks_total = 0, bricks_interesting = 0, bricks_read = 0, bricks_hidden = 0, bricks_unused = 0,
                bricks_damaged = 0, bricks_read_bytes = 0;
  /// Of several ranks: bricks whose files were in the memory of one when another, or it again, needed them.
  std::uint64_t bricks_shared = 0, bricks_shared_bytes = 0;
  /// Bricks without which a pixel would be another, and the bytes of their files: the least that a frame has to read.
  std::uint64_t bricks_contributing = 0, bricks_contributing_bytes = 0;
  std::uint64_t slab_bytes = 0;                            // that the threads drew with, at the most
  std::uint64_t peak_cache_bytes = 0, peak_rss_bytes = 0;  // of this frame and those before it
  std::vector<LevelStatistics> levels;                     // of the store, 0 first
  unsigned threads = 1;  // that draw; as many read beside them, where there are several
  BusyTimes busy;        // of what was done within wall_s
  /// The part of the drawing threads' time for which there was work, above 1 where readers have cores of their own.
  double utilisation() const { return wall_s > 0 ? busy.total() / (wall_s * threads) : 0; }
  std::map<StoredBrick, std::uint64_t> contributing;  // the bytes of their files
  std::set<StoredBrick> damaged;
  void addContributing(const StoredBrick& brick, std::uint64_t file_bytes);
  /// Adds what was drawn of the same frame elsewhere. Not: when it was begun, wall_s and output_s.
  void merge(const FrameStatistics& other);
  /// Adds what another view of the frame has cost, one after the other.
  void addView(const FrameStatistics& view);
};

/// Brick files of one rank, and their bytes.
struct SharedReadCounts {
  std::uint64_t read = 0, read_bytes = 0;          // from the disk, for itself and for others
  std::uint64_t received = 0, received_bytes = 0;  // from other ranks
  std::uint64_t sent = 0, sent_bytes = 0;          // to other ranks
};

/// What a rank did for a job. `busy_s` is all time but that in which it waited for others.
struct RankStatistics {
  int rank = 0;
  double busy_s = 0, idle_s = 0;
  std::uint64_t tiles = 0, frames_written = 0;
  std::uint64_t sent_bytes = 0, received_bytes = 0;
  /// Bricks that it read from the disk; files of bricks that others sent to it, and it to them.
  std::uint64_t bricks_read = 0, bricks_read_bytes = 0;
  std::uint64_t bricks_received = 0, bricks_received_bytes = 0, bricks_sent = 0, bricks_sent_bytes = 0;
  std::uint64_t voxels_visited = 0, voxels_splats = 0;
  std::uint64_t peak_cache_bytes = 0, peak_rss_bytes = 0;
  void add(const FrameStatistics& share);
  /// Where ranks share what they read: these are the bricks that it read, also for others, and no longer its frames'.
  void setReads(const SharedReadCounts& shared);
};

struct RenderStatistics {
  std::vector<FrameStatistics> frames;
  std::uint64_t budget_bytes = 0;  // of it cache_bytes for bricks, the rest for image, visibility, index and slabs
  std::uint64_t cache_bytes = 0, peak_cache_bytes = 0, framebuffer_bytes = 0, visibility_bytes = 0, index_bytes = 0,
                files_bytes = 0, threads_bytes = 0;
  std::uint64_t shared_reads_bytes = 0;  // of brick files that ranks send one another
  std::uint64_t trace_bytes = 0;         // of the trace, where one is kept
  std::uint64_t slabs_bytes = 0,
                peak_slabs_bytes = 0;  // to draw with (slabs, tiles of voxels): what is set aside, and what was needed
  std::uint64_t peak_rss_bytes = 0;
  double load_s = 0, render_s = 0, output_s = 0;
  std::vector<RankStatistics> ranks;  // where there are several
  std::string shared_by;              // what was handed out to them: "tiles", "frames", "bricks"
  std::vector<int> kept, failed;      // frames of a sequence that are not in `frames`
  /// Puts a frame behind the others, and into the sums.
  void add(const FrameStatistics& frame);
};

/// JSON. The keys are a contract (DESIGN §10): frames[].wall_s, frames[].voxels.visited, …, and the totals of the last
/// frame at the top level. unit: _s seconds, _bytes bytes, the rest counts.
std::string statisticsText(const RenderStatistics& statistics);

}  // namespace kiln
