// Transfer functions of CT presets, in Hounsfield units.
#pragma once

#include <string_view>
#include <vector>

#include "scene/transfer/transfer_function.h"

namespace kiln {

/// The length of material that has the opacity of a point.
/// - kVoxel: the mean spacing, for surfaces, which are as thick as the blur between two voxels.
/// - kObject: a share of the volume's size if that is larger (presets.cpp), for tissue that other tissue shows through.
enum class OpacityLength { kVoxel, kObject };

struct CtPreset {
  std::string_view name;
  OpacityLength length;
  std::vector<TransferPoint> points;  // values in Hounsfield units
  bool shaded = true;
};

/// In the order of a list for users.
const std::vector<CtPreset>& ctPresets();

}  // namespace kiln
