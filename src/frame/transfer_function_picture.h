// Draws a transfer function over the histogram of a volume.
#pragma once

#include "image/image.h"
#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Bars are counts of voxels on a logarithmic scale. The line is opacity, from 0 at the bottom to 1 at the top. The
/// band below shows the colours, in its lower half over a checkerboard by opacity. Numbers are values and opacities.
/// The histogram may be empty. shape: 960 × 420 pixels.
Image transferFunctionPicture(const TransferFunction& function, const ValueHistogram& histogram);

/// Returns the values that the picture spans: the function's points and the histogram, slightly widened.
ValueRange pictureRange(const TransferFunction& function, const ValueHistogram& histogram);

}  // namespace kiln
