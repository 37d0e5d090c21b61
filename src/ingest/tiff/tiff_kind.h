// Classifies a page by its tags and decides if Kiln can read it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "ingest/bytes/stored_type.h"

namespace kiln {

/// The treatment of pages of RGB colours.
enum class TiffColours { kRefused, kLuminance };

/// The tags that decide, with the numbers of the TIFF standard.
struct TiffKind {
  int photometric = 1, samples = 1, depth = 1, compression = 1, bits = 8, sample_format = 1, planes = 1;

  /// True for RGB, with or without opacity, of 8 or 16 bits, pixel by pixel.
  bool hasLuminance() const;
};

/// Returns the type of the page's values; empty if no voxel type holds them exactly.
std::optional<StoredType> storedTypeOf(const TiffKind& kind);

/// Returns the reason why such a page is not supported ("holds RGB colours, not one value a pixel"); empty if it is.
std::string refusalOf(const TiffKind& kind, TiffColours colours);

/// Replaces pixels of `samples` samples of `type`, red, green, blue and others, by their luminance: the weights of
/// ITU-R BT.709 on the stored values, rounded. requires: u8 or u16, and at least three samples.
std::vector<std::byte> luminanceOf(std::vector<std::byte> pixels, VoxelType type, int samples);

}  // namespace kiln
