// Colour maps available by name, over values from 0 to 1.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/transfer/color_map.h"

namespace kiln {

/// "viridis", "plasma", "inferno", "cool-to-warm", "fire".
const std::vector<std::string>& colorMapNames();

/// requires: a name of `colorMapNames`.
ColorMap namedColorMap(std::string_view name);

}  // namespace kiln
