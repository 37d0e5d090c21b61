// Makes a video out of the files of its frames, by ffmpeg.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/progress.h"
#include "job/render_job.h"

namespace kiln {

/// Reads the pictures in order, lays each over black as 8-bit sRGB and passes it to the encoder. The video is written
/// whole or not at all. Equal pictures give equal bytes with one version of the encoder. Reading a picture takes at
/// most `memory_bytes`. `record` becomes the video's comment; empty for none. throws: as readImage; Error kUsage where
/// pictures differ in size; kNotFound, kIo with the encoder's message; kCancelled.
void writeVideo(const std::vector<std::filesystem::path>& pictures, const VideoOptions& options,
                const std::string& record, std::uint64_t memory_bytes, Progress& progress);

/// The beginning of the records of Kiln's videos.
inline constexpr std::string_view kVideoRecord = "kiln:";

/// Returns whether the video at the path is readable to its end and has the record. cost: decodes all frames. throws:
/// Error kExists if the video is whole and has another record of Kiln's; kIo, kCancelled.
bool isVideoOf(const VideoOptions& options, const std::string& record, Progress& progress);

/// Returns the encoder's arguments. Odd sizes get one more row or column of black.
std::vector<std::string> encoderArguments(const VideoOptions& options, int width, int height, const std::string& record,
                                          const std::filesystem::path& file);

}  // namespace kiln
