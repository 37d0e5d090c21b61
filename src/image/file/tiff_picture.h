// Encodes and decodes TIFF pictures of 16 bits a channel. Hides libtiff from its users.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "image/image.h"
#include "image/image_rows.h"

namespace kiln {

bool looksLikeTiff(std::span<const std::byte> data);

/// Encodes RGBA of 16 bits a channel, straight alpha, sRGB, in deflated strips, and passes bytes with their offsets to
/// `put`. The texts are the description (image/file/text_block.h). Values outside of [0, 1] are clamped. Equal input
/// gives equal bytes. cost: a strip of rows beside a band. throws: Error kIo naming `path`; also any exception of
/// `rows` and `put`.
void encodeTiff(ImageRows& rows, const std::filesystem::path& path, const std::map<std::string, std::string>& text,
                const std::function<void(std::uint64_t offset, std::span<const std::byte>)>& put);

/// Returns the texts of encodeTiff. throws: Error kFormat naming `path`.
std::map<std::string, std::string> decodeTiffText(std::span<const std::byte> data, const std::filesystem::path& path);

/// Decodes a TIFF as encodeTiff writes it, in at most `memory_bytes` beside `data`. throws: Error kFormat, kUnsupported
/// for other TIFFs, kBudget naming `path`.
Image decodeTiff(std::span<const std::byte> data, const std::filesystem::path& path,
                 std::uint64_t memory_bytes = UINT64_MAX);
/// Decodes the file to its end and discards the pixels. throws: as decodeTiff.
void checkTiff(std::span<const std::byte> data, const std::filesystem::path& path);

}  // namespace kiln
