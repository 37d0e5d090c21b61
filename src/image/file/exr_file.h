// OpenEXR pictures as bytes in memory. OpenEXR lives behind this header.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "image/file/exr_head.h"
#include "image/file/image_file.h"
#include "image/file/scratch_output.h"
#include "image/image.h"
#include "image/image_rows.h"

namespace kiln {

bool looksLikeExr(std::span<const std::byte> data);

/// One scanline part: channels R G B A where the image has colours, and of each plane a channel of its name, which is
/// 32-bit float whatever the others are; equal input gives equal bytes. Half clamps what is beyond ±65504. `path` is
/// for errors. cost: the compressed file in memory beside the image. throws: Error kIo, kUsage (unknown compression).
std::vector<std::byte> encodeExr(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                                 const std::filesystem::path& path);

/// The same, band by band. throws: also what `rows` and `out` throw.
void encodeExr(ImageRows& rows, const ImageMetadata& metadata, const ImageFileOptions& options,
               const std::filesystem::path& path, ScratchOutput& out);

/// The same of several views: scanline parts whose attributes `name` and `view` are the view's name.
void encodeExrViews(std::span<const ImageView> views, const ImageFileOptions& options,
                    const std::filesystem::path& path, ScratchOutput& out);

/// The data window of the first part, with the planes that are named, in at most `memory_bytes` beside `data`. throws:
/// Error kFormat, kUnsupported, kBudget, naming `path`.
Image decodeExr(std::span<const std::byte> data, const std::filesystem::path& path,
                std::span<const std::string> planes = {}, std::uint64_t memory_bytes = kUnlimitedBytes);
/// Reads every channel of every row of every part. throws: Error kFormat where a part of the file is damaged or
/// missing; kBudget.
void checkExr(std::span<const std::byte> data, const std::filesystem::path& path,
              std::uint64_t memory_bytes = kUnlimitedBytes);
/// The header of the first part. cost: reads the headers alone. throws: Error kFormat, kUnsupported.
ExrPart readExrPart(const File& file);

}  // namespace kiln
