// Whether a store has more digits than a picture: files keep every value, pictures compute with 32-bit floats.
#pragma once

#include <string>

#include "store/manifest/manifest.h"

namespace kiln {

/// A sentence where values that differ are few as 32-bit floats, as with a large offset; empty where they are not.
std::string mergedValuesText(const Manifest& manifest);

}  // namespace kiln
