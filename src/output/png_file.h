// PNG pictures as bytes in memory. libpng lives behind this header.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "output/image.h"

namespace kiln {

bool looksLikePng(std::span<const std::byte> data);

/// RGBA of `bits` a channel (8 or 16), straight alpha, sRGB; equal input gives equal bytes. Values are clamped to what
/// PNG can hold. `path` is for errors. cost: the compressed file in memory beside the image. throws: Error kIo.
std::vector<std::byte> encodePng(const Image& image, int bits, const std::filesystem::path& path);

/// Any PNG, its values taken as sRGB. throws: Error kFormat naming `path`.
Image decodePng(std::span<const std::byte> data, const std::filesystem::path& path);

}  // namespace kiln
