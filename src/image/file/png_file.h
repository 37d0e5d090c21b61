// Encodes and decodes PNG pictures in memory. Hides libpng from its users.
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
#include "image/shown_row.h"

namespace kiln {

bool looksLikePng(std::span<const std::byte> data);

/// Encodes RGBA and texts (UTF-8; keys of 1 to 79 Latin-1 characters) with `bits` (8 or 16) per channel, straight
/// alpha, sRGB. Values outside the range of PNG are clamped. Colours of 8 bits are dithered (image/dither.h), alpha is
/// rounded. Equal input gives equal bytes. `path` is for errors. cost: the compressed file in memory beside the image.
/// throws: Error kIo.
std::vector<std::byte> encodePng(const Image& image, int bits, const std::filesystem::path& path,
                                 const std::map<std::string, std::string>& text = {}, const PatternPlace& place = {});

/// Encodes band by band and passes the file's bytes to `put` in order. cost: 64 rows beside a band. throws: also any
/// exception of `rows` and `put`.
void encodePng(ImageRows& rows, int bits, const std::filesystem::path& path,
               const std::map<std::string, std::string>& text, const PatternPlace& place,
               const std::function<void(std::span<const std::byte>)>& put);

/// Returns the texts in front of the pixels, in at most `memory_bytes` beside `data`. throws: Error kFormat, kBudget
/// naming `path`.
std::map<std::string, std::string> decodePngText(std::span<const std::byte> data, const std::filesystem::path& path,
                                                 std::uint64_t memory_bytes = UINT64_MAX);

/// Decodes any PNG, with values taken as sRGB, in at most `memory_bytes` beside `data`. throws: Error kFormat, kBudget
/// naming `path`.
Image decodePng(std::span<const std::byte> data, const std::filesystem::path& path,
                std::uint64_t memory_bytes = UINT64_MAX);
/// Reads the file to its end and discards the pixels. throws: as decodePng.
void checkPng(std::span<const std::byte> data, const std::filesystem::path& path,
              std::uint64_t memory_bytes = UINT64_MAX);

}  // namespace kiln
