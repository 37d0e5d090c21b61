// The files of a frame: names, contents, and the hash by which a later run recognises its own files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "job/render_job.h"
#include "sequence/opened_job.h"

namespace kiln {

/// Header key for the frames that decide camera and colours of a time series.
inline constexpr const char* kSeriesKey = "kiln:series";

/// Returns the files of a frame, with the frame's number in their names; kept frames of a video are among them.
std::vector<OutputFile> filesOf(const RenderJob& job, int frame);
/// Checks, before a frame is drawn, that its files can be made. throws: as FileSystem::requirePlaceFor.
void requirePlaces(const RenderJob& job, int frame);
/// Returns the file whose colours the video takes. requires: a video.
OutputFile videoFrameOf(const RenderJob& job, int frame);
/// Returns true for a video if no other output can be its frames.
bool keepsFramesForVideo(const RenderJob& job);
/// Returns the folder of a video's own frames.
std::filesystem::path keptFramesOf(const VideoOptions& video);

/// throws: Error kUsage for a name without a picture's ending, a picture too large for its kind of file, a name without
/// a place for the number of several frames, or two files with equal names.
void requireOutputs(const RenderJob& job, const std::vector<int>& frames);

/// Returns the job of one file of a frame, with every choice made, as stored in an EXR's header.
std::string frameText(const RenderJob& job, const OutputFile& file, const FrameScene& scene);

/// Returns a hash, as 32 digits, of everything that a file's pixels depend on: scene, content of the volume, kind of
/// file, version of Kiln. Paths, other frames, threads, memory and exact visibility methods do not enter.
std::string contentHash(const RenderJob& job, const OutputFile& file, const FrameScene& scene,
                        const Manifest& manifest);

/// Writes all files of a frame, each whole or not at all, and records the time. The drawn pictures then have their
/// background. Compression takes up to `writer_bytes`
/// (FrameMemory::files). throws: Error kNoSpace, kIo.
void writeFrame(const RenderJob& job, int frame, DrawnFrame& drawn, const BrickedVolume& store,
                std::uint64_t writer_bytes);

/// Returns the bytes of the PNG that the job writes for a frame without planes. Changes nothing of the frame. throws:
/// as encodedPng; Error kCancelled.
std::vector<std::byte> pngOf(const RenderJob& job, const DrawnFrame& drawn, const BrickedVolume& store,
                             const Progress& progress);

enum class FoundFile { kMissing, kDamaged, kWhole };
/// Reads a file to its end. Returns true if this job wrote the file. throws: Error kExists if another job wrote the
/// file, with the difference if known.
FoundFile findFile(const RenderJob& job, const OutputFile& file, const FrameScene& scene, const BrickedVolume& store);

}  // namespace kiln
