// A video out of the files of its frames, by ffmpeg.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/progress.h"
#include "job/render_job.h"

namespace kiln {

/// Reads the pictures in their order, lays each over black as 8-bit sRGB and hands it to the encoder; the video is
/// there whole or not at all. Equal pictures give equal bytes with one version of the encoder. throws: Error of
/// readImage; kUsage where pictures differ in size; kNotFound, kIo with the encoder's complaint; kCancelled.
/// Each picture is read in at most `memory_bytes`.
void writeVideo(const std::vector<std::filesystem::path>& pictures, const VideoOptions& options,
                std::uint64_t memory_bytes, Progress& progress);

/// What the encoder is told. The video is odd in no direction: a last row or column of black is added where it must.
std::vector<std::string> encoderArguments(const VideoOptions& options, int width, int height,
                                          const std::filesystem::path& file);

}  // namespace kiln
