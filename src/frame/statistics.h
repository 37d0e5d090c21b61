// The cost of a render: sums over frames, shares of ranks, and the JSON of `--stats`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "frame/pass/frame_statistics.h"

namespace kiln {

/// Brick files of one rank and their sizes.
struct SharedReadCounts {
  std::uint64_t read = 0, read_bytes = 0;          // from the disk, for this rank and others
  std::uint64_t received = 0, received_bytes = 0;  // from other ranks
  std::uint64_t sent = 0, sent_bytes = 0;          // to other ranks
};

/// The work of one rank. `busy_s` excludes waiting for other ranks.
struct RankStatistics {
  int rank = 0;
  double busy_s = 0, idle_s = 0;
  std::uint64_t tiles = 0, frames_written = 0;
  std::uint64_t sent_bytes = 0, received_bytes = 0;
  /// Bricks read from the disk, received from other ranks and sent to them.
  std::uint64_t bricks_read = 0, bricks_read_bytes = 0;
  std::uint64_t bricks_received = 0, bricks_received_bytes = 0, bricks_sent = 0, bricks_sent_bytes = 0;
  std::uint64_t voxels_visited = 0, voxels_splats = 0;
  std::uint64_t peak_cache_bytes = 0, peak_rss_bytes = 0;
  void add(const FrameStatistics& share);
  /// Sets the bricks read for all ranks (shared reads) instead of the bricks of the rank's frames. Without shared reads
  /// the bricks of the frames stay.
  void setReads(const SharedReadCounts& shared);
};

/// Brick files that were read to fit a camera to what is visible.
struct FitReads {
  std::uint64_t files = 0, bytes = 0;
};

struct RenderStatistics {
  std::vector<FrameStatistics> frames;
  std::uint64_t budget_bytes = 0;  // memory: cache_bytes for bricks, the rest for image, visibility, index and slabs
  std::uint64_t cache_bytes = 0, peak_cache_bytes = 0, framebuffer_bytes = 0, visibility_bytes = 0, index_bytes = 0,
                files_bytes = 0, threads_bytes = 0;
  std::uint64_t shared_reads_bytes = 0;  // for brick files that ranks exchange
  std::uint64_t trace_bytes = 0;         // for the trace, if any
  std::uint64_t functions_bytes = 0;     // for transfer functions
  std::uint64_t shadows_bytes = 0;       // shadow maps and ambient occlusion: planned
  std::uint64_t slabs_bytes = 0,
                peak_slabs_bytes = 0;  // memory to draw with (slabs, tiles of voxels): planned, and peak
  std::uint64_t peak_rss_bytes = 0;
  FitReads fit;
  double load_s = 0, render_s = 0, output_s = 0;
  std::vector<RankStatistics> ranks;  // empty for one process
  std::string shared_by;              // the unit that ranks share: "tiles", "frames", "bricks"
  std::vector<int> kept, failed;      // frames of a sequence missing in `frames`
  /// Appends a frame without its lists of bricks, which grow with the volume, and adds the frame to the sums.
  void add(const FrameStatistics& frame);
};

/// Returns JSON. The keys are a contract with scripts: frames[].wall_s, frames[].voxels.visited, …, and the totals of
/// the last frame at the top level. unit: _s seconds, _bytes bytes, all other keys counts.
std::string statisticsText(const RenderStatistics& statistics);

}  // namespace kiln
