// Default transfer functions: by name, or chosen from the histogram.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/transfer/color_map.h"
#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// In the order of a list for users; "iso:VALUE" is available in addition, for any number.
const std::vector<std::string>& presetNames();
/// Returns the names as a sentence: "auto, ct-skin, … or iso:VALUE".
std::string presetList();

/// True if the name is in the list, or begins with "iso:".
bool isPreset(std::string_view name);

/// Returns a preset mapped to this volume's values.
/// - "auto" depends on class, look and histogram: fog for a fog, the zero surface for a level set, palette colours for
///   labels; the window and colour that the source declares, with rising opacity; else the surface between empty space
///   (the lower Otsu class) and the object.
/// - ct- presets are in Hounsfield units.
/// - "iso:VALUE" is solid from VALUE on.
/// - mr- presets are found in the histogram.
/// - colour maps (grayscale, viridis, …) begin above empty space and rise in opacity.
/// throws: Error kUsage naming the presets, or the fault in VALUE.
TransferFunction presetFor(std::string_view name, const Manifest& manifest);

/// Returns black to white over the range of values, or to the colour over the window that the source declares, in equal
/// display steps, opaque, as viewers of slices and projections show values.
TransferFunction displayRamp(const Manifest& manifest);

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
