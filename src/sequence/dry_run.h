// What a render would cost, without drawing: nothing is read but the manifest and the index.
#pragma once

#include <string>

#include "frame/frame_memory.h"
#include "frame/statistics.h"
#include "job/render_job.h"

namespace kiln {

struct DryRun {
  int samples = 1;  // a pixel, in the frame that has the most; memory is for these
  std::uint64_t bricks_total = 0;
  std::uint64_t bricks_interesting = 0;  // hold something the transfer function shows
  std::uint64_t bricks_in_view = 0;      // of these, in the image: a frame asks for no others
  std::uint64_t files_in_view = 0;       // of these, not constant
  /// Of these files: the most that a frame reads, or a band of its sub-pixels where the cache keeps nothing for the
  /// next. What is hidden behind opaque parts is not read. unit: bytes.
  std::uint64_t file_bytes_in_view = 0;
  /// What all bricks in view take in memory, decoded. unit: bytes.
  std::uint64_t decoded_bytes_in_view = 0;
  EmptyFrame empty = EmptyFrame::kShows;  // why nothing is to be seen
  bool one_colour = false;                // FrameStatistics::one_colour
  FrameMemory memory;
  std::uint64_t budget_bytes = 0;
};

/// Of the job's first frame; `beside` are charged with the image (besideBytes). throws: Error kUsage, kNotFound,
/// kFormat, kDamaged (manifest and index); not kBudget: the answer says what works.
DryRun dryRun(const RenderJob& job, const MemoryBeside& beside = 0);

/// JSON for `--stats`: the keys of a render's statistics where they mean the same.
std::string dryRunText(const DryRun& run);

}  // namespace kiln
