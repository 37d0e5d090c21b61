// Figure 7: a slice through the octree with the nodes that one frame asked about, the light running to the right.
#pragma once

#include "bench/measurements.h"
#include "bench/svg.h"

namespace kiln {

/// The finest nodes that were visited are filled, nodes above them outlined, hidden nodes shaded. The slice is turned
/// by quarters and mirrored so that the view runs from left to right. shape: the world's proportions.
Svg drawNodeSlice(const NodeSlice& slice, const VolumeSummary& volume);

}  // namespace kiln
