// The files of a frame: their names, what each holds, and how a later run knows its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "job/render_job.h"
#include "sequence/opened_job.h"

namespace kiln {

/// The text of a picture's header that names the frames by which a time series is framed and coloured.
inline constexpr const char* kSeriesKey = "kiln:series";

/// The files of a frame, its number in their names. A video alone has its frames kept beside it.
std::vector<OutputFile> filesOf(const RenderJob& job, int frame);
/// Before a frame is drawn: that its files can be made. throws: as FileSystem::requirePlaceFor.
void requirePlaces(const RenderJob& job, int frame);
/// Of those, the one whose colours a video takes. requires: a video.
std::filesystem::path videoFrameOf(const RenderJob& job, int frame);
/// Whether the job asks for its frames as a video only, for which they are kept, and where that is.
bool keepsFramesForVideo(const RenderJob& job);
std::filesystem::path keptFramesOf(const VideoOptions& video);

/// throws: Error kUsage where a name is no picture's, has no place for the number of several frames, or where two of
/// these frames' files are one.
void requireOutputs(const RenderJob& job, const std::vector<int>& frames);

/// The job that draws a file of a frame, every choice made, as an EXR's header holds it.
std::string frameText(const RenderJob& job, const OutputFile& file, const FrameScene& scene);

/// What a file's pixels depend on, as a text of 32 digits: the scene, the volume's content, the kind of file and this
/// version of Kiln. Not: where the files are, which frames there are, threads, memory and exact visibility methods.
std::string contentHash(const RenderJob& job, const OutputFile& file, const FrameScene& scene,
                        const Manifest& manifest);

/// Writes all files of a frame, each of them whole or not at all, and notes how long it took. Compressing them takes up
/// to `writer_bytes` (FrameMemory::files). throws: Error kNoSpace, kIo.
void writeFrame(const RenderJob& job, int frame, DrawnFrame& drawn, const StoreReader& store,
                std::uint64_t writer_bytes);

enum class FoundFile { kMissing, kDamaged, kWhole };
/// Whether the file is there and this job's, read to its end. throws: Error kExists where it is another job's picture,
/// saying what differs where that is known.
FoundFile findFile(const RenderJob& job, const OutputFile& file, const FrameScene& scene, const StoreReader& store);

}  // namespace kiln
