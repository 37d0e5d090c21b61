// The partial images of ranks put together in the order in which they are seen: by sending each rank the strip of rows
// that it puts together, and only what of them shows something; or by MPI's own reduction, whose pixels are all of one
// size, so that it knows nothing of edges' layers. Pictures are made the first way; a benchmark has both.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cluster/ranks.h"
#include "render/part_order.h"

namespace kiln {

enum class CompositeBy { kReduction, kDirectSend };

struct PartImage {
  int width = 0;
  std::vector<PartPixel> pixels;            // rows of `width`
  std::shared_ptr<const EdgeLayers> edges;  // of the same pixels, however they are counted; null: there are none
};

/// Collective. Makes `image` on the first rank the picture of all ranks' in `order`, front to back; on the others it is
/// then without meaning. requires: images of one size.
void compositeRanks(Ranks& ranks, PartImage& image, std::span<const int> order, float opaque_at, CompositeBy by);

}  // namespace kiln
