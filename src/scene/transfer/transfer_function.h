// Maps voxel values to colour and opacity: piecewise linear between points; the end points extend outside.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <variant>
#include <vector>

#include "grid/value_range.h"

namespace kiln {

struct TransferPoint {
  double value = 0;
  glm::dvec3 color{1};  // linear light, 0..1
  double opacity = 0;   // per `unit` of length, 0..1
  bool operator==(const TransferPoint&) const = default;
};

/// Factor on a sample's opacity at a given gradient length.
struct GradientPoint {
  double gradient = 0;  // gradient length. unit: value per world unit
  double factor = 1;    // 0..1
  bool operator==(const GradientPoint&) const = default;
};

struct Classified {
  glm::dvec3 color;
  double opacity;
};

/// A surface through all places at which the interpolated value is `value`. Values of `value` and above are inside.
struct IsoSurface {
  double value = 0;
  glm::dvec3 color{0.80, 0.76, 0.69};  // ivory; linear light, 0..1
  double opacity = 1;                  // of each crossing of the surface, at any angle, 0..1
  bool operator==(const IsoSurface&) const = default;
};

/// Appearance of a label of a label volume.
struct LabelStyle {
  double label = 0;
  std::string name;
  glm::dvec3 color{1};  // linear light, 0..1
  double opacity = 1;   // per `unit` of length, 0..1
  bool operator==(const LabelStyle&) const = default;
};

struct TransferFunction {
  /// Reference length of `opacity`; 0 means the volume's mean spacing. unit: the volume's own world, so that its
  /// optical depth does not depend on other volumes of another unit (`inWorld` converts).
  double unit = 0;
  /// Sorted by value; points may share a value (a step: the last of them holds from there on).
  std::vector<TransferPoint> points;

  /// Factor on opacity as a function of the gradient's length: sorted, linear between points, the end points extend
  /// outside. Empty leaves opacities unchanged.
  std::vector<GradientPoint> gradient_opacity = {};

  /// For a label volume, instead of points: sorted and unique. Labels without an entry are transparent. Between voxels,
  /// a label holds where it has more than half of the interpolation weight.
  std::vector<LabelStyle> labels = {};

  /// Instead of points: sorted by value, each value once. Between the surfaces nothing is visible.
  std::vector<IsoSurface> surfaces = {};

  /// Returns the reference length of opacity in a volume with this mean spacing. unit: world.
  double unitIn(double mean_spacing) const { return unit > 0 ? unit : mean_spacing; }
  /// In 0..1.
  double gradientFactor(double gradient) const;
  /// NaN is transparent, and so are labels without an entry, and all values of a function of surfaces. cost: a binary
  /// search.
  Classified at(double value) const;
  /// cost: a binary search.
  bool hasLabel(double label) const;
  /// True if a label in [lo, hi] is not transparent.
  bool labelsShownIn(double lo, double hi) const;
  bool interesting(double value) const { return at(value).opacity > 0; }
  /// True if values below and values inside some visible surface are in [lo, hi]. cost: a binary search.
  bool surfacesCrossedIn(double lo, double hi) const;
  bool operator==(const TransferFunction&) const = default;
};

/// Converts the function's lengths to a world with `world_per_own` units per unit of the volume's own world.
TransferFunction inWorld(TransferFunction function, double world_per_own);

/// Converts opacity per `unit` to extinction: -ln(1 - min(opacity, 0.9999)) / unit. unit: 1 / world.
double extinctionOf(double opacity, double unit);

/// The name of a preset, a transfer function file (FILE, or FILE#NAME for one map of several), or the function itself.
using TransferFunctionChoice = std::variant<std::string, std::filesystem::path, TransferFunction>;

/// Values from centre - width/2 to centre + width/2, as radiologists set it. unit: the volume's values.
struct Window {
  double centre = 0, width = 1;
  bool operator==(const Window&) const = default;
};

}  // namespace kiln
