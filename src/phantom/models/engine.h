// An engine block: a casting of aluminium with iron liners in its bores, for what industrial CT looks at.
#pragma once

#include "phantom/models/figure.h"

namespace kiln::phantom {

/// The extents of the block's box, centred on the origin. unit: mm.
inline constexpr double kEngineBoxMm[3] = {256, 256, 110};

PartList engineParts();

}  // namespace kiln::phantom
