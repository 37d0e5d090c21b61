// A label volume as a function of index space, in double precision. The share of each shown label is interpolated
// separately. A position is solid if the shares sum to at least a half; it belongs to the label with the largest share.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "scene/transfer/transfer_function.h"
#include "support/reference/reference_field.h"

namespace kiln::test {

/// thread: safe.
class ReferenceLabels {
 public:
  /// Interpolates shares linearly or by cubic B-spline. Opacities are smoothed by binomial weights over `smoothing`
  /// voxels to either side.
  ReferenceLabels(const DenseVolume& volume, const TransferFunction& function, Interpolation interpolation,
                  int smoothing);

  struct There {
    Classified look;
    double solid;  // solidity from 0 to 1: a ramp around a sum of shares of 1/2
  };
  There at(const glm::dvec3& index) const;
  /// Gradient of the labels' smoothed opacities: the derivative of the cubic B-spline. unit: opacity per voxel.
  glm::dvec3 gradient(const glm::dvec3& index) const { return opacity_.gradient(index); }

 private:
  struct Label {
    Classified look;
    ReferenceField share;
  };
  std::vector<Label> labels_;
  ReferenceField opacity_;
};

}  // namespace kiln::test
