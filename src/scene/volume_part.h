// The I-th of N parts of a volume: boxes of about equal size that fill it, made by halving, so that from wherever one
// looks there is an order in which no part is hidden by one after it.
#pragma once

#include <optional>
#include <string_view>

#include "grid/coords.h"

namespace kiln {

/// From 1 to `count`.
struct PartNumber {
  int index = 1, count = 1;
  bool operator==(const PartNumber&) const = default;
};

inline constexpr int kMostParts = 65536;

/// "I/N", as the command line and jobs say it; nothing where the text is none of them.
std::optional<PartNumber> partNumbered(std::string_view text);

/// Cut between bricks where there are enough of them. throws: Error kUsage where the volume has too few voxels.
VoxelBox boxOfPart(const PartNumber& part, const Extent3& dims, std::int64_t brick_size);

}  // namespace kiln
