// Deep OpenEXR pictures, written row by row.
#pragma once

#include <filesystem>

#include "image/deep_samples.h"
#include "image/file/image_file.h"
#include "image/file/scratch_output.h"

namespace kiln {

/// One deep scanline part, as writeDeepImage says; equal input gives equal bytes. `path` is for errors. cost: a
/// row. throws: Error kIo, kUsage (compression); what `out` throws.
void encodeDeepExr(const DeepSamples& samples, const ImageMetadata& metadata, const ImageFileOptions& options,
                   const std::filesystem::path& path, ScratchOutput& out);

}  // namespace kiln
