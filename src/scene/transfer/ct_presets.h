// Transfer functions of CT presets, in Hounsfield units.
#pragma once

#include <string_view>
#include <vector>

#include "scene/transfer/transfer_function.h"

namespace kiln {

struct CtPreset {
  std::string_view name;
  std::vector<TransferPoint> points;  // values in Hounsfield units, opacities per mean spacing
};

/// In the order of a list for users.
const std::vector<CtPreset>& ctPresets();

}  // namespace kiln
