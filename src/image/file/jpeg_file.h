// Encodes and decodes JPEG pictures in memory. Hides libjpeg from its users.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "image/image_rows.h"

namespace kiln {

/// The longest side of a JPEG. unit: pixels.
inline constexpr int kLargestJpegSide_px = 65500;

bool looksLikeJpeg(std::span<const std::byte> data);

/// Encodes opaque pixels as sRGB; alpha is ignored. `quality`: 1 to 100; from 90 on each pixel has its own colour.
/// Values outside [0, 1] are clamped. Texts are in comments (image/file/text_block.h). Equal input gives equal bytes.
/// cost: the compressed file in memory. throws: Error kIo; also any exception of `rows`.
std::vector<std::byte> encodeJpeg(ImageRows& rows, int quality, const std::map<std::string, std::string>& text = {});

/// Returns the texts of encodeJpeg. throws: Error kFormat naming `path`.
std::map<std::string, std::string> decodeJpegText(std::span<const std::byte> data, const std::filesystem::path& path);

/// Decodes a JPEG with values taken as sRGB, in at most `memory_bytes` beside `data`: the pixels, and the coefficients
/// of a progressive file. throws: Error kFormat, kBudget naming `path`.
Image decodeJpeg(std::span<const std::byte> data, const std::filesystem::path& path,
                 std::uint64_t memory_bytes = UINT64_MAX);
/// Decodes the file to its end and discards the pixels. throws: as decodeJpeg.
void checkJpeg(std::span<const std::byte> data, const std::filesystem::path& path,
               std::uint64_t memory_bytes = UINT64_MAX);

}  // namespace kiln
