// Figure 7: a slice through the octree with the nodes tested by a frame; the view runs to the right.
#pragma once

#include "bench/measurements.h"
#include "bench/report/svg.h"

namespace kiln {

/// Fills the finest visited nodes, outlines the nodes above them, shades hidden nodes. The slice is turned by quarters
/// and mirrored so that the view runs from left to right. shape: the world's proportions.
Svg drawNodeSlice(const NodeSlice& slice, const VolumeSummary& volume);

}  // namespace kiln
