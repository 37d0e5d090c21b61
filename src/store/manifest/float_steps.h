// Detects values that 32-bit floats merge: a store keeps every value, but pictures are computed with 32-bit floats.
#pragma once

#include <string>

#include "store/manifest/manifest.h"

namespace kiln {

/// Returns a sentence if distinct values become few 32-bit floats, as with a large offset; else empty.
std::string mergedValuesText(const Manifest& manifest);

}  // namespace kiln
