// Ranges of values and opacities over which presets and colour maps are stretched in a volume.
#pragma once

#include "scene/transfer/color_map.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Returns the volume's range of values without outliers (the range of its histogram), or a substitute for volumes
/// without values (all NaN) or with a single value. Never empty, lo < hi.
ValueRange usableRange(const Manifest& manifest);

/// Returns the values over which a colour map is stretched: of a fog from 0 on, else from the surface between empty
/// space and the object on, as in "auto"; to the value that few voxels exceed. Never empty, lo < hi.
ValueRange colorMapRange(const Manifest& manifest);

/// Returns the opacity of a colour map over these values, per mean voxel spacing: nothing at their begin, translucent
/// in the middle, opaque within a fraction of the volume at their end.
OpacityCurve risingOpacity(const ValueRange& range, const Manifest& manifest);

}  // namespace kiln
