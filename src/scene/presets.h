// Transfer functions for people who bring none: by name, or chosen from the histogram.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/transfer_function.h"
#include "store/manifest.h"

namespace kiln {

/// "auto", "ct-skin", "ct-bone", "mr-head", "fog", "levelset", "grayscale", in the order a list should show them.
const std::vector<std::string>& presetNames();

/// A preset mapped to this volume's values. "auto" looks at the class and the histogram: a fog is a fog, a level set
/// its zero surface, anything else the surface between what is empty (the lower Otsu class) and what is not. throws:
/// Error kUsage naming the presets there are.
TransferFunction presetFor(std::string_view name, const Manifest& manifest);

}  // namespace kiln
