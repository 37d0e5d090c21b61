// A tile of a picture, as bytes that are kept or sent, and its pixels put where they belong.
#pragma once

#include <optional>
#include <vector>

#include "base/byte_record.h"
#include "image/image.h"
#include "image/pixel_rect.h"

namespace kiln {

/// Puts a tile's pixels into an image of `whole`'s, which has the planes of the tile or none yet. requires: `at`, where
/// the tile lies, is in `whole`.
void putTile(const Image& tile, const PixelRect& at, const PixelRect& whole, Image& image);

/// Adds a tile's place, its colours and its planes, as floats.
void appendTile(std::vector<std::byte>& out, const PixelRect& at, const Image& tile);

/// Of the tile that lies at `at`, which has been taken: the rest of the bytes, or nothing where they are not one's.
std::optional<Image> takeTile(ByteTaker& taker, const PixelRect& at);

}  // namespace kiln
