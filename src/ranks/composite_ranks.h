// Problem: put the partial images of all ranks over one another, front to back.
// Method: direct send. Each rank composites one strip of rows and receives only visible rectangles.
// Source: Hsu, Segmented Ray Casting for Data Parallel Volume Rendering, 1993.
#pragma once

#include <span>

#include "cluster/ranks.h"
#include "image/image.h"
#include "job/render_job.h"

namespace kiln {

/// Collective. Composites the ranks' parts, in `order` front to back, into the samples of the picture on rank 0. Other
/// ranks return an unspecified image. requires: parts of equal size, with the planes of `aovs`.
Image compositeDirectly(Ranks& ranks, Image& part, const Aovs& aovs, std::span<const int> order,
                        float opacity_threshold);

}  // namespace kiln
