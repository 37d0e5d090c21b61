// Values over which projections (`--mode`) run from black to white if the user gives no window.
#pragma once

#include "grid/value_range.h"
#include "scene/render_options.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Returns the values that a projection of the volume is likely to show, from its histogram alone: pictures of all
/// cameras, frames and crops have equal colours. `shown`: the share of the volume that clipping leaves, above 0 up
/// to 1. Never empty, lo < hi; inside usableRange, which is returned for level sets and volumes of one value. requires:
/// a mode that projects.
ValueRange projectionRange(const Manifest& manifest, Mode mode, double shown = 1);

}  // namespace kiln
