// Classifies a page by its tags and decides if Kiln can read it.
#pragma once

#include <optional>
#include <string>

#include "ingest/bytes/stored_type.h"

namespace kiln {

/// The tags that decide, with the numbers of the TIFF standard.
struct TiffKind {
  int photometric = 1, samples = 1, depth = 1, compression = 1, bits = 8, sample_format = 1;
};

/// Returns the type of the page's values; empty if no voxel type holds them exactly.
std::optional<StoredType> storedTypeOf(const TiffKind& kind);

/// Returns the reason why such a page is not supported ("holds RGB colours, not one value a pixel"); empty if it is.
std::string refusalOf(const TiffKind& kind);

}  // namespace kiln
