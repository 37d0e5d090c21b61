// Problem: draw the frames of a job by ranks that hold different bricks (`--distribute bricks`).
// Method: sort-last. In every frame each rank draws a partial image of its box, and the partial images are composited
// front to back. A rank reads the same bricks for every frame.
// Source: Molnar et al. 1994.
#pragma once

#include "sequence/sequence.h"

namespace kiln {

/// As runSequence, by several ranks; pictures equal a single process's within 1/255. throws: also Error kUsage for a
/// job that cannot be drawn in parts.
SequenceResult shareBricksOfSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                                     SequenceListener& listener);

/// Returns the memory for a part's samples, for sending and for compositing. unit: bytes.
std::uint64_t partBytes(const RenderJob& job);

}  // namespace kiln
