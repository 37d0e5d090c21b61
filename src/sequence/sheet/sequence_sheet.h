// A contact sheet of a sequence: some of its frames, drawn small, with their numbers. The sequence's own files are not
// written.
#pragma once

#include <vector>

#include "base/progress.h"
#include "image/image.h"
#include "sequence/sequence_frames.h"

namespace kiln {

inline constexpr int kMostSheetFrames = 400;
/// The size of a frame of a sheet that has no size.
inline constexpr ImageSize kSheetFrameSize{256, 256};

/// Returns `count` of the job's frames at equal steps, the first among them, and the last unless the frames are a
/// full turn; all frames if there are fewer.
std::vector<int> framesOfSheet(const RenderJob& job, int count);

/// throws: Error kUsage naming --sheet for a job that a sheet cannot show: fewer than two frames, more files than one
/// picture, a name for each frame or eye, a deep or partial image, both eyes.
void requireSheet(const RenderJob& job);

/// Draws the job's frames in rows, as wide as high if possible. Writes the job's trace, and warns as runSequence.
/// `store_for` is as in SequenceOptions. throws: as SequenceFrames; kBudget if the sheet does not fit in the memory.
Image drawSequenceSheet(const RenderJob& job, const StoreFor& store_for, Progress& progress);

}  // namespace kiln
