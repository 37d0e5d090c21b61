// Converts tiles of a picture to bytes for files and messages, and back.
#pragma once

#include <optional>
#include <vector>

#include "base/byte_record.h"
#include "image/image.h"
#include "image/pixel_rect.h"

namespace kiln {

/// Copies a tile at `at` into an image of the pixels `whole`, which has the tile's planes or none yet. requires: `at`
/// is inside `whole`.
void putTile(const Image& tile, const PixelRect& at, const PixelRect& whole, Image& image);

/// Appends a tile's rectangle, colours and planes, as floats.
void appendTile(std::vector<std::byte>& out, const PixelRect& at, const Image& tile);

/// Takes colours and planes of a tile whose rectangle `at` was taken before. Returns nothing if the bytes are no tile.
std::optional<Image> takeTile(ByteTaker& taker, const PixelRect& at);

}  // namespace kiln
