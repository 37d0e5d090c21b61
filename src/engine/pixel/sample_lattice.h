// What the samples of a zone of slabs share, and kernels need of it.
#pragma once

#include "engine/shared/plain_light.h"
#include "scene/interpolation.h"

namespace kiln {

struct SampleLattice {
  Interpolation interpolation = Interpolation::kLinear;
  int label_smoothing = 0;  // of a label volume, how far smoothing of opacities reaches. unit: voxels
  bool perspective = false;
  float focal = 1;      // unit: pixels per x/z, or in a parallel view per world unit
  float thickness = 1;  // of a slab. unit: world
  // Classification, see SampleTable.
  const float* table = nullptr;        // shape: entries of r, g, b, tau
  const float* extinctions = nullptr;  // shape: entries
  float table_scale = 1, table_last = 0;
  // Samples have extinction between these places of the table only.
  float visible_after = -1, visible_before = 3e38f;
  // Where a voxel stands for the interval of values that it is the mean of: the extinction is the mean over it. Null
  // where a sample is a point.
  const float* integral = nullptr;
  float least_interval = 1;
  // More than that is done for each sample by itself (engine/pixel/finish_sample.h), and then there is no light here.
  PlainLight light;
};

}  // namespace kiln
