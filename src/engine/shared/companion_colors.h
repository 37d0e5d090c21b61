// The colours of a companion's values (companion/color_values.h), every choice made.
#pragma once

#include "grid/value_range.h"
#include "grid/voxel_type.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

struct CompanionColors {
  TransferFunction function;
  VoxelType type = VoxelType::u8;
  ValueRange range;  // of the companion's values
};

}  // namespace kiln
