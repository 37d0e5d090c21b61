// The frames of a job where ranks share bricks (DESIGN §8, sort-last): each draws a partial image of its own box of the
// volume, of each frame, and the partial images are composited in the order in which they are seen. A rank reads the
// same bricks for every frame, and no others.
#pragma once

#include "sequence/sequence.h"

namespace kiln {

/// As runSequence, by several ranks; the pictures are those of one process within 1/255. throws: also Error kUsage
/// where the job cannot be drawn in parts.
SequenceResult shareBricksOfSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                                     SequenceListener& listener);

/// The part's samples, as they are sent, and as they are composited. unit: bytes.
std::uint64_t partBytes(const RenderJob& job);

}  // namespace kiln
