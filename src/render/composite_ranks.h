// The partial images of ranks put together in the order in which they are seen: by sending each rank the strip of rows
// that it puts together, and only what of them shows something; or by MPI's own reduction, whose pixels are all of one
// size, so that it knows nothing of edges' layers. Pictures are made the first way; a benchmark has both.
#pragma once

#include <span>
#include <vector>

#include "cluster/ranks.h"
#include "render/part_order.h"

namespace kiln {

/// Collective. Makes of all ranks' parts, in `order` front to back, the picture of the first rank: rows as the parts';
/// of the others it is without meaning. requires: parts of one size, each with the plane of what is covered.
std::vector<PartPixel> compositeDirectly(Ranks& ranks, const Image& part, std::span<const int> order, float opaque_at);

/// The same by reduction: of pixels without layers, in place.
void compositeByReduction(Ranks& ranks, std::vector<PartPixel>& pixels, std::span<const int> order, float opaque_at);

}  // namespace kiln
