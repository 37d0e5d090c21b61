// Composites the partial images of ranks in the order in which they are seen ("direct send", Hsu, "Segmented ray
// casting for data parallel volume rendering", 1993): each rank composites a strip of rows, and gets only what shows
// something.
#pragma once

#include <span>

#include "cluster/ranks.h"
#include "image/image.h"
#include "job/render_job.h"

namespace kiln {

/// Collective. Makes of all ranks' parts, in `order` front to back, the samples of the first rank's picture; the result
/// of other ranks has no meaning. requires: parts of one size, with the planes of `aovs`.
Image compositeDirectly(Ranks& ranks, Image& part, const Aovs& aovs, std::span<const int> order, float opaque_at);

}  // namespace kiln
