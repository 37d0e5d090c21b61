// From a voxel's value to colour and opacity: piecewise linear between points, the end points hold outside.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "grid/value_range.h"

namespace kiln {

struct TransferPoint {
  double value = 0;
  glm::dvec3 color{1};  // linear light, 0..1
  double opacity = 0;   // per `unit` of length, 0..1
};

/// The part of a sample's opacity that is left where the values change this fast.
struct GradientPoint {
  double gradient = 0;  // its length. unit: value per world unit
  double factor = 1;    // 0..1
};

struct Classified {
  glm::dvec3 color;
  double opacity;
};

/// How a label of a label volume looks.
struct LabelStyle {
  double label = 0;
  std::string name;
  glm::dvec3 color{1};  // linear light, 0..1
  double opacity = 1;   // per `unit` of length, 0..1
};

struct TransferFunction {
  /// The length that `opacity` is per. unit: the volume's own world, so that a volume has the same optical depth beside
  /// volumes of another unit (`inWorld` converts); 0 means the volume's mean spacing.
  double unit = 0;
  /// Sorted by value; several points may share a value (a step: the last of them holds from there on).
  std::vector<TransferPoint> points;

  /// What opacity is multiplied by, over the length of the gradient: sorted, linear between points, the end points hold
  /// outside. Nothing here leaves opacities as they are.
  std::vector<GradientPoint> gradient_opacity = {};

  /// Of a label volume instead of points: sorted, none twice; labels that are not here are transparent. Between voxels
  /// a label is where more than half of what is interpolated is.
  std::vector<LabelStyle> labels = {};

  /// The length that opacity is per in a volume of that spacing. unit: world.
  double unitIn(double mean_spacing) const { return unit > 0 ? unit : mean_spacing; }
  /// In 0..1.
  double gradientFactor(double gradient) const;
  /// NaN is transparent; of labels, what is none of them. cost: a binary search.
  Classified at(double value) const;
  /// Of several labels: whether one of them in [lo, hi] is not transparent.
  bool labelsShownIn(double lo, double hi) const;
  bool interesting(double value) const { return at(value).opacity > 0; }
};

/// The function with its lengths in a world that has `world_per_own` lengths per length of the volume's own.
TransferFunction inWorld(TransferFunction function, double world_per_own);

/// Opacity per `unit` as extinction: -ln(1 - min(opacity, 0.9999)) / unit. unit: 1 / world.
double extinctionOf(double opacity, double unit);

}  // namespace kiln
