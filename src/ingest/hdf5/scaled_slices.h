// Values that a file of MINC scales slice by slice: the least and the largest whole number of each slice stand for
// numbers of that slice.
#pragma once

#include <memory>
#include <vector>

#include "ingest/source/volume_source.h"

namespace kiln {

/// value = stored * slope + intercept.
struct SliceScale {
  double slope = 1, intercept = 0;
};

struct SliceScales {
  /// The voxel axis across the slices: 0 is x.
  int axis = 2;
  /// Scale of each slice; empty if values are taken as stored.
  std::vector<SliceScale> slices;
};

/// Returns the values of `source` as 32-bit floats. requires: whole numbers, and a scale for each slice.
std::unique_ptr<VolumeSource> scaledSlices(std::unique_ptr<VolumeSource> source, SliceScales scales);

}  // namespace kiln
