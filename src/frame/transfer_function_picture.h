// A transfer function as a picture over the histogram of a volume: what a person looks at before drawing.
#pragma once

#include "image/image.h"
#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Bars are counts of voxels on a logarithmic scale, the line is opacity from 0 at the bottom to 1 at the top, the band
/// below has the colours, brighter where they are more opaque over a checkerboard; numbers are the volume's values and
/// the opacity. The histogram may be empty. shape: 960 × 420 pixels.
Image transferFunctionPicture(const TransferFunction& function, const ValueHistogram& histogram);

/// The values that the picture spans: the function's points and the histogram, a little wider.
ValueRange pictureRange(const TransferFunction& function, const ValueHistogram& histogram);

}  // namespace kiln
