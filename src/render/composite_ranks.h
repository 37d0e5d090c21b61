// The partial images of ranks put together in the order in which they are seen: by MPI's own reduction, or by sending
// each rank the strip of rows that it puts together, and only what of them shows something.
#pragma once

#include <span>
#include <vector>

#include "cluster/ranks.h"
#include "render/part_order.h"

namespace kiln {

enum class CompositeBy { kReduction, kDirectSend };

/// Which is faster for so many pixels, by `composite_bench` of tests/bench.
CompositeBy fasterComposite(std::size_t pixels, int ranks);

/// Collective. Makes `pixels` on the first rank the picture of all ranks' in `order`, front to back; on the others they
/// are then without meaning. shape: rows of `width`, as many on each rank.
void compositeRanks(Ranks& ranks, std::vector<PartPixel>& pixels, int width, std::span<const int> order,
                    float opaque_at, CompositeBy by);

}  // namespace kiln
