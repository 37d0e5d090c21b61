// Transfer functions for people who bring none: by name, or chosen from the histogram.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// In the order a list should show them; "iso:VALUE" is one more, for any number.
const std::vector<std::string>& presetNames();
/// The names as a sentence has them: "auto, ct-skin, … or iso:VALUE".
std::string presetList();

/// Whether the name is one of the list, or begins with "iso:".
bool isPreset(std::string_view name);

/// A preset mapped to this volume's values. "auto" looks at the class and the histogram: a fog is a fog, a level set
/// its zero surface, anything else the surface between what is empty (the lower Otsu class) and what is not. The ct-
/// presets are in Hounsfield units, "iso:VALUE" is solid from VALUE on, colour maps (viridis, …) rise in opacity over
/// the range of values. throws: Error kUsage naming the presets there are, or what is wrong with VALUE.
TransferFunction presetFor(std::string_view name, const Manifest& manifest);

/// From black to white over the range of values in equal steps of a display, as viewers of slices and projections show
/// values; opaque.
TransferFunction displayGrey(const Manifest& manifest);

/// The volume's range of values, without a few that are far from all others (as its histogram has it), or one to map to
/// where it has none (all NaN) or one value only. Never empty, lo < hi.
ValueRange usableRange(const Manifest& manifest);

/// Opacity per mean voxel spacing at which the box of the volume, seen along its mean diagonal, is nearly opaque.
double grayscaleOpacity(const Manifest& manifest);

}  // namespace kiln
