// PNG pictures as bytes in memory. libpng lives behind this header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "image/image_rows.h"

namespace kiln {

bool looksLikePng(std::span<const std::byte> data);

/// RGBA and texts (UTF-8, by keys of 1 to 79 Latin letters and signs); `bits` a channel (8 or 16), straight alpha,
/// sRGB; equal input gives equal bytes. Values are clamped to what PNG can hold. `path` is for errors. cost: the
/// compressed file in memory beside the image. throws: Error kIo.
std::vector<std::byte> encodePng(const Image& image, int bits, const std::filesystem::path& path,
                                 const std::map<std::string, std::string>& text = {});

/// The same, band by band: passes the file's bytes to `put` piece by piece, from front to back. cost: 64 rows beside a
/// band. throws: also what `rows` and `put` throw.
void encodePng(ImageRows& rows, int bits, const std::filesystem::path& path,
               const std::map<std::string, std::string>& text,
               const std::function<void(std::span<const std::byte>)>& put);

/// The texts in front of the pixels, in at most `memory_bytes` beside `data`. throws: Error kFormat, kBudget naming
/// `path`.
std::map<std::string, std::string> decodePngText(std::span<const std::byte> data, const std::filesystem::path& path,
                                                 std::uint64_t memory_bytes = UINT64_MAX);

/// Any PNG, its values taken as sRGB, in at most `memory_bytes` beside `data`. throws: Error kFormat, kBudget naming
/// `path`.
Image decodePng(std::span<const std::byte> data, const std::filesystem::path& path,
                std::uint64_t memory_bytes = UINT64_MAX);
/// Reads the file to its end and keeps nothing. throws: as decodePng.
void checkPng(std::span<const std::byte> data, const std::filesystem::path& path,
              std::uint64_t memory_bytes = UINT64_MAX);

}  // namespace kiln
