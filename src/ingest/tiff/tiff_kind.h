// What a page's tags say that it is, and which of those kinds Kiln reads.
#pragma once

#include <optional>
#include <string>

#include "grid/voxel_type.h"

namespace kiln {

/// The tags that decide; the numbers are TIFF's own.
struct TiffKind {
  int photometric = 1, samples = 1, depth = 1, compression = 1, bits = 8, sample_format = 1;
};

/// The type of voxel that holds the page's values exactly; empty where there is none.
std::optional<VoxelType> voxelTypeOf(const TiffKind& kind);

/// Why a page of this kind is not read ("holds RGB colours, not one value a pixel"); empty where it is.
std::string refusalOf(const TiffKind& kind);

}  // namespace kiln
