// Problem: draw the frames of a job by several ranks. Method: sort-first. Whole frames, or tiles of frames, are handed
// out as ranks become free. A rank has its own cache and memory. The ranks take turns at assembling a frame of tiles
// and writing its files; rank 0 receives a report of every frame and makes the video. Source: Molnar et al. 1994.
#pragma once

#include "sequence/sequence.h"

namespace kiln {

/// As runSequence, by several ranks. A frame that fails on one rank has failed. Errors that concern several frames are
/// thrown on rank 0.
SequenceResult shareSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                             SequenceListener& listener);

/// Returns the memory of a rank beside its assembled image: a tile being drawn with its rays, a tile being sent and a
/// tile being received. unit: bytes.
std::uint64_t sharedTileBytes(const RenderJob& job);

}  // namespace kiln
