// Windows of values in grey or in the colours of a map, as slices and cut faces show them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/clipping.h"
#include "scene/transfer/color_map.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// "gray", and the colour maps of named_color_maps.h.
std::vector<std::string> displayMapNames();
/// Returns the map over values from 0 to 1. requires: a name of displayMapNames().
ColorMap displayMap(std::string_view name);
/// Returns the window of the middle 99 % of the values.
Window defaultWindow(const ValueHistogram& histogram);
/// Returns "CENTRE,WIDTH" with the digits that distinguish values of the window.
std::string windowText(const Window& window);

/// Returns the colours of a section's values, opaque. requires: a colour map and a window.
TransferFunction functionOf(const Section& section);

/// Returns the section with a window for its colour map. throws: Error kUsage for a colour map of labels, and for
/// colours of a function of surfaces.
Section resolved(Section section, const Manifest& manifest, const TransferFunction& function);

}  // namespace kiln
