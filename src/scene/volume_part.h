// The I-th of N parts of a volume: boxes of about equal size that fill the volume. The boxes are made by halving, so
// from every viewpoint there is an order in which no part is hidden by a later part.
#pragma once

#include <optional>
#include <string_view>

#include "grid/coords.h"
#include "scene/clipping.h"

namespace kiln {

inline constexpr int kMostParts = 65536;

/// Parses "I/N", the form on the command line and in jobs; nothing for any other text.
std::optional<PartNumber> partNumbered(std::string_view text);

/// Cuts between bricks if there are enough bricks. throws: Error kUsage if the volume has too few voxels.
VoxelBox boxOfPart(const PartNumber& part, const Extent3& dims, std::int64_t brick_size);

}  // namespace kiln
