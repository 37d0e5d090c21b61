// Opacity and colour by gradient length, for single voxels: the transfer function's, at the length of a voxel's
// gradient. Prepared once for each level of a frame.
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "engine/shared/classifier.h"
#include "engine/shared/projector.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

class GradientOpacity {
 public:
  /// Leaves materials unchanged.
  GradientOpacity() = default;
  /// `unit` is the length that opacities refer to. requires: `function` outlives the object.
  GradientOpacity(const TransferFunction& function, double unit, const Projector& level)
      : function_(function.usesGradient() ? &function : nullptr),
        unit_(unit),
        view_from_index_gradient_(level.viewFromIndexGradient()) {}

  bool active() const { return function_ != nullptr; }

  /// Material of a voxel. requires: active. unit: gradient: value per voxel of the level.
  Material operator()(double value, const glm::vec3& index_gradient) const {
    const Classified look = function_->at(value, glm::length(view_from_index_gradient_ * glm::dvec3(index_gradient)));
    const glm::vec3 color(look.color);
    return {color.r, color.g, color.b, static_cast<float>(extinctionOf(look.opacity, unit_))};
  }

 private:
  const TransferFunction* function_ = nullptr;
  double unit_ = 1;
  glm::dmat3 view_from_index_gradient_{1};
};

}  // namespace kiln
