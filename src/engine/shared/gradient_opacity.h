// Opacity that depends on how fast the values change: the transfer function's factor over the length of the gradient,
// prepared once for each level of a frame.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "engine/shared/projector.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

class GradientOpacity {
 public:
  /// Leaves every opacity as it is.
  GradientOpacity() = default;
  /// `unit` is the length that opacities are per. requires: the function outlives this.
  GradientOpacity(const TransferFunction& function, double unit, const Projector& level)
      : function_(function.gradient_opacity.empty() ? nullptr : &function),
        unit_(unit),
        view_from_index_gradient_(level.viewFromIndexGradient()) {}

  bool active() const { return function_ != nullptr; }

  /// The extinction of a sample whose value has extinction `tau`: its opacity per unit times the factor. never above
  /// tau. unit: 1 / world; the gradient value per voxel of the level.
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
