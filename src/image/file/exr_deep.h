// Writes deep OpenEXR pictures row by row.
#pragma once

#include <filesystem>

#include "image/deep_samples.h"
#include "image/file/image_file.h"
#include "image/file/scratch_output.h"

namespace kiln {

/// Writes one deep scanline part as specified by writeDeepImage; equal input gives equal bytes. `path` is for errors.
/// cost: memory of a row. throws: Error kIo, kUsage (compression); any exception of `out`.
void encodeDeepExr(const DeepSamples& samples, const ImageMetadata& metadata, const ImageFileOptions& options,
                   const std::filesystem::path& path, ScratchOutput& out);

}  // namespace kiln
