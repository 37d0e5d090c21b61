// An engine block for industrial CT: an aluminium casting with iron liners in its bores.
#pragma once

#include "phantom/models/figure.h"

namespace kiln::phantom {

/// Extents of the block's box, centred on the origin. unit: mm.
inline constexpr double kEngineBoxMm[3] = {256, 256, 110};

PartList engineParts();

}  // namespace kiln::phantom
