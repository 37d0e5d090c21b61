// The frames of a job shared by ranks (DESIGN §8, sort-first): whole frames, or tiles of them, are handed out as ranks
// come free. A rank draws with its own cache, under its own memory. Of a frame that is drawn in tiles, one rank, in
// turn, puts them together and writes the files; the first rank is told of every frame, and makes the video.
#pragma once

#include "sequence/sequence.h"

namespace kiln {

/// As runSequence, by several ranks. A frame that fails on any rank has failed; what is no frame's is thrown there,
/// with the frame's number where the job has only one.
SequenceResult shareSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                             SequenceListener& listener);

/// Beside the image that a rank may put together: a tile of its own, its rays, one that it sends and one that it gets.
/// unit: bytes.
std::uint64_t sharedTileBytes(const RenderJob& job);

}  // namespace kiln
