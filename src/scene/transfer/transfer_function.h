// Maps voxel values to colour and opacity: piecewise linear between points; the end points extend outside.
// Opacity may also depend on the gradient, by points, or by regions or a table over values and gradients.
// Source: Levoy 1988 (opacity by value and gradient); Kniss, Kindlmann and Hansen 2002 (regions of the plane).
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "grid/value_range.h"
#include "scene/shading.h"

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

/// - kRectangle: all values and gradients between the limits.
/// - kTriangle: the tip is in the middle of the values at the least gradient; the base is at the greatest gradient. A
///   boundary between two materials has such a shape.
enum class RegionShape { kRectangle, kTriangle };

/// A visible region of the plane.
struct GradientRegion {
  RegionShape shape = RegionShape::kRectangle;
  glm::dvec2 values{0, 1};               // least and greatest
  glm::dvec2 gradients{0, 1};            // least and greatest. unit: value per world unit
  double opacity = 1;                    // factor on the opacity of the value, 0..1
  double softness = 0.2;                 // share of the half width over which the factor rises at an edge, 0..1
  std::optional<glm::dvec3> color = {};  // linear light, 0..1; none: the colour of the value
  /// Returns the factor in 0..opacity. An edge at gradient 0 is not soft.
  double at(double value, double gradient) const;
  bool operator==(const GradientRegion&) const = default;
};

/// Factors on a grid whose first and last nodes lie at the limits, linear between nodes; the last nodes extend outside.
struct GradientTable {
  glm::dvec2 values{0, 1};     // of the first and the last column
  glm::dvec2 gradients{0, 1};  // of the first and the last row. unit: value per world unit
  int columns = 0, rows = 0;   // none: no table
  std::vector<float> opacity;  // shape: columns × rows, values first; 0..1
  double at(double value, double gradient) const;
  bool operator==(const GradientTable&) const = default;
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

  /// Instead of gradient_opacity: the greatest factor of all regions at a value and a gradient. Colours of regions that
  /// overlap mix by their factors.
  std::vector<GradientRegion> regions = {};
  /// Instead of gradient_opacity and regions.
  GradientTable table = {};

  /// False: colours without light, whatever the light of the picture.
  bool shaded = true;
  /// Instead of surfaces' shading: light from the lights and from all around. Light reaches all samples, whatever their
  /// gradient.
  std::optional<Scattering> scattering = {};

  /// Returns the reference length of opacity in a volume with this mean spacing. unit: world.
  double unitIn(double mean_spacing) const { return unit > 0 ? unit : mean_spacing; }
  /// True if opacity or colour depends on the gradient.
  bool usesGradient() const { return !gradient_opacity.empty() || !regions.empty() || table.columns > 0; }
  /// Factor on the opacity of a value at a gradient's length. In 0..1.
  double gradientFactor(double value, double gradient) const;
  /// Colour and opacity of a value at a gradient's length. cost: as `at`, and proportional to the number of regions.
  Classified at(double value, double gradient) const;
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

/// Returns the light of a picture as samples of the function reflect or scatter it.
Shading shadingOf(const TransferFunction& function, Shading light);

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
