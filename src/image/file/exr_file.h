// Encodes and decodes OpenEXR pictures in memory. Hides OpenEXR from its users.
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

/// Encodes one scanline part: channels R G B A if the image has colours, and a 32-bit float channel per plane. Equal
/// input gives equal bytes. Half clamps values beyond ±65504. `path` is for errors. cost: the compressed file in memory
/// beside the image. throws: Error kIo, kUsage (unknown compression).
std::vector<std::byte> encodeExr(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                                 const std::filesystem::path& path);

/// Encodes band by band. throws: also any exception of `rows` and `out`.
void encodeExr(ImageRows& rows, const ImageMetadata& metadata, const ImageFileOptions& options,
               const std::filesystem::path& path, ScratchOutput& out);

/// Encodes several views: scanline parts whose attributes `name` and `view` are the name of the view.
void encodeExrViews(std::span<const ImageView> views, const ImageFileOptions& options,
                    const std::filesystem::path& path, ScratchOutput& out);

/// Decodes the data window of the first part and the named planes, in at most `memory_bytes` beside `data`. throws:
/// Error kFormat, kUnsupported, kBudget, naming `path`.
Image decodeExr(std::span<const std::byte> data, const std::filesystem::path& path,
                std::span<const std::string> planes = {}, std::uint64_t memory_bytes = kUnlimitedBytes);
/// Reads every channel of every row of every part. throws: Error kFormat if a part is damaged or missing; kBudget.
void checkExr(std::span<const std::byte> data, const std::filesystem::path& path,
              std::uint64_t memory_bytes = kUnlimitedBytes);
/// Reads the header of the first part. cost: reads headers only. throws: Error kFormat, kUnsupported.
ExrPart readExrPart(const File& file);

}  // namespace kiln
