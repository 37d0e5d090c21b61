// A figure: named parts in an order of precedence. A part is a smooth union of solids filled with up to three layers of
// tissue.
// The tissue at a point is known in closed form: the last part that holds the point wins, and in this part the deepest
// layer. Left is +x, back is +y, up is +z (patient frame LPS), in millimetres.
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "phantom/models/shape.h"
#include "phantom/models/tissue.h"

namespace kiln::phantom {

/// Layers from the inside: `inner` below the shell of each solid, `outer` above, and a rind of constant thickness.
struct Layers {
  Tissue inner, outer, rind;
  double rind_mm = 0;
};
constexpr Layers filledWith(Tissue tissue) { return {tissue, tissue, tissue, 0}; }
constexpr Layers shellOf(Tissue outer, Tissue inner) { return {inner, outer, outer, 0}; }

/// Grooves cut into a part from its surface along a labyrinth, as in the brain: depth, period and half width. The
/// part's outer layer, as thick as its first shape's shell, lines the grooves.
struct Folds {
  double depth_mm = 0, period_mm = 1, half_width_mm = 0;
};

/// A part as written in the tables.
struct PartSpec {
  std::string name;
  Layers layers;
  std::vector<ShapeSpec> shapes;
  Folds folds = {};
};
using PartList = std::vector<PartSpec>;

/// Adds a part, given for the left side, and its mirror image: "left femur", "right femur".
void addPair(PartList& parts, const std::string& name, const Layers& layers, const std::vector<ShapeSpec>& shapes);
/// Returns the shapes and their mirror images.
std::vector<ShapeSpec> bothSides(const std::vector<ShapeSpec>& shapes);
inline void append(std::vector<ShapeSpec>& to, const std::vector<ShapeSpec>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

struct Part {
  std::string name;
  Layers layers;
  /// Range in the figure's list of shapes.
  std::size_t first = 0, count = 0;
  Folds folds;
  bool layered() const { return layers.inner != layers.outer; }
};

/// unit: index into `Figure::parts`.
using PartId = std::size_t;
inline constexpr PartId kOutside = static_cast<PartId>(-1);

struct Place {
  PartId part = kOutside;
  Tissue tissue = Tissue::kAir;
};

class Figure {
 public:
  /// requires: parts in order of rising precedence.
  explicit Figure(const PartList& parts);

  std::span<const Part> parts() const { return parts_; }
  std::span<const Shape> shapes() const { return shapes_; }
  /// Distance from its box at which a shape may still affect the surfaces of its part. shape: one number per shape.
  /// unit: mm.
  std::span<const float> reaches() const { return reaches_; }

  /// The part and tissue at a point. cost: all shapes, a few microseconds.
  Place placeAt(const glm::vec3& point_mm) const;
  Tissue tissueAt(const glm::vec3& point_mm) const { return placeAt(point_mm).tissue; }
  /// Signed distances of a point to a part's surface and to its inner tissue. unit: mm.
  struct Depth {
    float outer, inner;
  };
  Depth depthIn(const Part& part, const glm::vec3& point_mm) const;
  /// Returns null if no part has the name.
  const Part* find(std::string_view name) const;

 private:
  std::vector<Part> parts_;
  std::vector<Shape> shapes_;
  std::vector<float> reaches_;
};

}  // namespace kiln::phantom
