// Silhouettes of a picture and the pixels around them, where a ray either meets a body or misses it.
#pragma once

#include <vector>

#include "image/image.h"

namespace kiln::test {

/// Returns the pixels at most two away from a silhouette, on either side. A silhouette separates two neighbours if
/// alpha passes one half between them, or if their depths differ by more than `jump`. shape: `depth` and the result as
/// the picture's pixels, row by row. unit: `depth` and `jump` world, infinity for pixels without a hit.
std::vector<bool> silhouetteBand(const Image& picture, const std::vector<double>& depth, double jump);

/// Returns the PSNR over RGB of linear premultiplied values, peak 1. unit: dB; infinity for equal pixels, or if `band`
/// is empty.
double psnrWithin(const std::vector<bool>& band, const Image& a, const Image& b);

}  // namespace kiln::test
