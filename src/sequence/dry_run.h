// Predicts the cost of a render from manifest and index alone.
#pragma once

#include <string>
#include <vector>

#include "frame/frame_memory.h"
#include "frame/statistics.h"
#include "job/render_job.h"
#include "sequence/opened_job.h"
#include "sequence/opened_volumes.h"

namespace kiln {

struct DryRun {
  int samples = 1;  // per pixel, in the frame with most samples; `memory` is for this frame
  std::uint64_t bricks_total = 0;
  std::uint64_t bricks_interesting = 0;  // bricks with a value that the transfer function shows
  std::uint64_t bricks_in_view = 0;      // interesting bricks inside the image; a frame reads no other bricks
  std::uint64_t files_in_view = 0;       // bricks in view that are not constant
  /// Upper bound for the bytes read by a frame, or by a band of sub-pixels if the cache keeps no bricks between bands.
  /// Bricks hidden behind opaque parts are not read. unit: bytes.
  std::uint64_t file_bytes_in_view = 0;
  /// Size in memory of all bricks in view, decoded. unit: bytes.
  std::uint64_t decoded_bytes_in_view = 0;
  /// Bricks that shadow maps and ambient occlusion of the frame read at most, also bricks in view. unit: bytes: stored.
  std::uint64_t bricks_of_lights = 0, files_of_lights = 0, file_bytes_of_lights = 0;
  EmptyFrame empty = EmptyFrame::kShows;  // the reason for an empty picture
  bool one_colour = false;                // FrameStatistics::one_colour
  std::vector<Doubt> doubts;              // reasons to doubt the picture, as the render would warn of
  FrameMemory memory;
  std::uint64_t budget_bytes = 0;
};

/// Predicts the job's first frame; `beside` is charged with the image (besideBytes). throws: Error kUsage, kNotFound,
/// kFormat, kDamaged (manifest and index). Never throws kBudget: the result has the smallest memory that works.
DryRun dryRun(const RenderJob& job, const MemoryBeside& beside = 0);

/// Predicts the first frame from open volumes. requires: the volumes are the job's first frame's, and `series` is set.
/// throws: Error kCancelled.
DryRun dryRun(const RenderJob& job, const OpenedVolumes& volumes, const MemoryBeside& beside = 0,
              const Progress& progress = Progress());

/// Returns JSON for `--stats`, with the keys of a render's statistics where the meaning is equal.
std::string dryRunText(const DryRun& run);

}  // namespace kiln
