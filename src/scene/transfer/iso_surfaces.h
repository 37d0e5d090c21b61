// Iso-surfaces in one line: "iso:300:0.5:#f80,1200" has the surfaces VALUE[:OPACITY[:COLOR]].
#pragma once

#include <string_view>

#include "scene/transfer/transfer_function.h"

namespace kiln {

/// The beginning of such a text.
inline constexpr std::string_view kIso = "iso:";

/// Returns the surfaces of the text behind `iso:`. The opacity is 1 and the colour ivory unless the text states others.
/// throws: Error kUsage "'iso:TEXT': expected …".
TransferFunction isoSurfaces(std::string_view text);

}  // namespace kiln
