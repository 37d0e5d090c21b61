// A volume as a function of index space: interpolation in double precision, voxel by voxel.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "scene/render_options.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// scene/render_options.h. thread: safe.
class ReferenceField {
 public:
  ReferenceField(const DenseVolume& volume, Interpolation interpolation);

  /// Returns NaN if a voxel with weight is NaN. unit: index space, also beyond the volume.
  double at(const glm::dvec3& index) const;
  /// Gradient at voxel scale: for linear interpolation the central difference over two voxels along each axis, for a
  /// cubic the derivative of the cubic B-spline. unit: value per voxel.
  glm::dvec3 gradient(const glm::dvec3& index) const;

  double voxel(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return values_[static_cast<std::size_t>((k * dims_.y + j) * dims_.x + i)];
  }

 private:
  using Kernel = double (*)(double);
  struct Filtered {
    double sum = 0;
    ValueRange range;  // range of the voxels with weight
  };
  double linearAt(const glm::dvec3& index) const;
  Filtered filtered(const glm::dvec3& index, const std::array<Kernel, 3>& kernels) const;

  Extent3 dims_;
  Interpolation interpolation_;
  std::vector<double> values_;
};

}  // namespace kiln::test
