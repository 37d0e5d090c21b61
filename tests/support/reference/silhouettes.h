// Edges of what a picture shows, and the pixels around these edges: there a ray meets a body or passes it by.
#pragma once

#include <vector>

#include "image/image.h"

namespace kiln::test {

/// Pixels at most two away from a silhouette, on either side: two neighbours are parted by one where alpha passes one
/// half between them, or where their depths are farther apart than `jump`. shape: `depth` and the result as the
/// picture's pixels, row by row. unit: `depth` and `jump` world, infinity where nothing is met.
std::vector<bool> silhouetteBand(const Image& picture, const std::vector<double>& depth, double jump);

/// Over RGB of linear premultiplied values, peak 1. unit: dB; infinity where equal, or where `band` has no pixel.
double psnrWithin(const std::vector<bool>& band, const Image& a, const Image& b);

}  // namespace kiln::test
