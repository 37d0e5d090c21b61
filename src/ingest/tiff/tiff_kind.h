// Classifies a page by its tags and decides if Kiln can read it.
#pragma once

#include <optional>
#include <string>

#include "grid/voxel_type.h"

namespace kiln {

/// The tags that decide, with the numbers of the TIFF standard.
struct TiffKind {
  int photometric = 1, samples = 1, depth = 1, compression = 1, bits = 8, sample_format = 1;
};

/// Returns the voxel type that holds the page's values exactly; empty if there is no such type.
std::optional<VoxelType> voxelTypeOf(const TiffKind& kind);

/// Returns the reason why such a page is not supported ("holds RGB colours, not one value a pixel"); empty if it is.
std::string refusalOf(const TiffKind& kind);

}  // namespace kiln
