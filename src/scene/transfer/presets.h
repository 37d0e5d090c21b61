// Default transfer functions: by name, or chosen from the histogram.
#pragma once

#include <string>
#include <string_view>
#include <vector>

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
/// - "auto" depends on class and histogram: fog for a fog, the zero surface for a level set, palette colours for
///   labels, else the surface between empty space (the lower Otsu class) and the object.
/// - ct- presets are in Hounsfield units.
/// - "iso:VALUE" is solid from VALUE on.
/// - colour maps (viridis, …) rise in opacity over the range of values.
/// throws: Error kUsage naming the presets, or the fault in VALUE.
TransferFunction presetFor(std::string_view name, const Manifest& manifest);

/// Returns black to white over the range of values in equal display steps, opaque, as viewers of slices and projections
/// show values.
TransferFunction displayGrey(const Manifest& manifest);

/// Returns the volume's range of values without outliers (the range of its histogram), or a substitute for volumes
/// without values (all NaN) or with a single value. Never empty, lo < hi.
ValueRange usableRange(const Manifest& manifest);

/// Returns the opacity per mean voxel spacing at which the volume's box is nearly opaque along its mean diagonal.
double grayscaleOpacity(const Manifest& manifest);

}  // namespace kiln
