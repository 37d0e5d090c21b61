// Opacity by gradient length: the transfer function's factor for the length of a sample's gradient. Prepared once for
// each level of a frame.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "engine/shared/projector.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

class GradientOpacity {
 public:
  /// Leaves opacities unchanged.
  GradientOpacity() = default;
  /// `unit` is the length that opacities refer to. requires: `function` outlives the object.
  GradientOpacity(const TransferFunction& function, double unit, const Projector& level)
      : function_(function.gradient_opacity.empty() ? nullptr : &function),
        unit_(unit),
        view_from_index_gradient_(level.viewFromIndexGradient()) {}

  bool active() const { return function_ != nullptr; }

  /// Extinction of a sample: opacity per unit length times the factor, never above `tau`. unit: 1 / world; gradient:
  /// value per voxel of the level.
  float operator()(float tau, const glm::vec3& index_gradient) const {
    const double factor =
        function_->gradientFactor(glm::length(view_from_index_gradient_ * glm::dvec3(index_gradient)));
    const double opacity = -std::expm1(-static_cast<double>(tau) * unit_);
    return factor < 1 ? static_cast<float>(extinctionOf(factor * opacity, unit_)) : tau;
  }

 private:
  const TransferFunction* function_ = nullptr;
  double unit_ = 1;
  glm::dmat3 view_from_index_gradient_{1};
};

}  // namespace kiln
