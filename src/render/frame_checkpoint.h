// One long frame, tile by tile: each tile that is finished is kept beside the picture, under a name that nothing takes
// for one, until the picture is there. A tile's pixels are the whole frame's bit for bit, so it does not matter which
// run drew it.
#pragma once

#include <filesystem>
#include <vector>

#include "base/pixel_rect.h"
#include "render/opened_job.h"

namespace kiln {

/// The file of a frame's tiles: the name of its first file with ".tiles" added. requires: the job names a file.
std::filesystem::path checkpointOf(const RenderJob& job, int frame);

/// What drawing in tiles takes beside the image. unit: bytes.
std::uint64_t checkpointBytes(const RenderJob& job);

/// throws: Error kUsage where a frame of this job is not kept in tiles: its pixels would depend on them, or on what
/// was damaged when they were drawn.
void requireCheckpoint(const RenderJob& job);

/// As OpenedJob::draw, tile by tile, with progress in pixels. Tiles that are kept of the same frame are taken where
/// `resume` says so; what is kept of another is replaced. The file stays for the caller to remove, when the frame's
/// files are written. The statistics are of what was drawn. throws: as OpenedJob::draw; of kCancelled it says how to go
/// on; Error kExists where tiles of this frame are kept and nobody resumes it, kNoSpace, kIo.
DrawnFrame drawInTiles(OpenedJob& opened, int frame, bool resume, Progress& progress);

/// The tiles of a frame, which fill `pixels`, neighbours behind each other.
std::vector<PixelRect> checkpointTiles(const PixelRect& pixels);

}  // namespace kiln
