// Encodes JPEG pictures in memory, for previews. Hides libjpeg from its users.
#pragma once

#include <cstddef>
#include <vector>

#include "image/image_rows.h"

namespace kiln {

/// Encodes opaque pixels as sRGB; alpha is ignored. `quality`: 1 to 100. Values outside [0, 1] are clamped. Equal input
/// gives equal bytes. cost: 3 bytes a pixel beside the file. throws: Error kIo; also any exception of `rows`.
std::vector<std::byte> encodeJpeg(ImageRows& rows, int quality);

}  // namespace kiln
