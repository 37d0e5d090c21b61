// Default transfer functions: by name, or chosen from the histogram.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "grid/value_range.h"
#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// In the order of a list for users; "iso:VALUE,..." and "solid:VALUE" are available in addition, for any
/// numbers.
const std::vector<std::string>& presetNames();
/// Returns the names as a sentence: "auto, ct-skin, …, iso:VALUE,... or solid:VALUE".
std::string presetList();

/// Returns "; did you mean 'ct-bone'?" for a misspelt preset; empty if no preset is near.
std::string presetHint(std::string_view text);

/// True if the name is in the list, or begins with "iso:" or "solid:".
bool isPreset(std::string_view name);
/// Tests the numbers of "iso:" and "solid:" names before a volume is there. throws: Error kUsage without an option's
/// name.
void requirePresetNumbers(std::string_view name);

/// Returns a preset mapped to this volume's values.
/// - "auto" depends on class, look and histogram: fog for a fog, the zero surface for a level set, palette colours for
///   labels; the window and colour that the source declares, with rising opacity; else the surface between empty space
///   (the lower Otsu class) and the object.
/// - ct- presets are in Hounsfield units.
/// - "iso:VALUE,..." are surfaces at the values (iso_surfaces.h).
/// - "solid:VALUE" is solid from VALUE on.
/// - mr- presets are found in the histogram.
/// - colour maps (grayscale, viridis, …) begin above empty space and rise in opacity.
/// throws: Error kUsage naming the presets, or the fault in VALUE.
TransferFunction presetFor(std::string_view name, const Manifest& manifest);

/// Returns black to white over `range`, or to the colour over the window that the source declares. The function is
/// opaque, in equal display steps, as viewers of slices and projections show values.
TransferFunction displayRamp(const Manifest& manifest, const ValueRange& range,
                             const std::optional<glm::dvec3>& color = {});

/// True for presets that stretch colours over the volume's values: colour maps and "grayscale".
bool isStretched(std::string_view name);

}  // namespace kiln
