// A transfer function in one line: "300:0,500:0.5:#f80" has the points VALUE:OPACITY[:COLOR].
#pragma once

#include <string_view>

#include "scene/transfer/transfer_function.h"

namespace kiln {

/// Returns whether a number ends at the first colon of the text. Preset names begin with letters, and "./" in front
/// makes any text a file name, so that the three are told apart without a look at the disk.
bool isPointsText(std::string_view text);

/// The unit of the function is 0: opacities are per mean spacing. A point without a colour has the colour of the point
/// before; the first points, the first colour of the text, else white. throws: Error kUsage "expected …, found …".
TransferFunction functionOfPoints(std::string_view text);

}  // namespace kiln
