// Deep OpenEXR pictures as bytes in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "base/deep_samples.h"
#include "output/image_file.h"

namespace kiln {

/// One deep scanline part, as writeDeepImage says; equal input gives equal bytes. `path` is for errors. cost: the
/// compressed file in memory, and a row. throws: Error kIo, kUsage (compression).
std::vector<std::byte> encodeDeepExr(const DeepSamples& samples, const ImageMetadata& metadata,
                                     const ImageFileOptions& options, const std::filesystem::path& path);

}  // namespace kiln
