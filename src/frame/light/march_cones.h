// Marches cones from points through means of a lattice of transmittances, a vector of points at a time.
// Method. A step looks up the nearest cell of the level whose cells are as long as the step.
// Invariant. A point's cones depend on no other point: every instruction set returns equal bits.
// Cost. A gather for each step of a cone and vector of points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/memory/large_pages.h"
#include "engine/shared/ambient_occlusion.h"
#include "grid/coords.h"

namespace kiln {

/// Transmittances of paths as long as a cell's edge; cells outside are clear.
class OpenLevel {
 public:
  /// All cells are clear.
  explicit OpenLevel(const Extent3& cells);

  const Extent3& cells() const { return cells_; }
  /// Cells in memory along each axis: one more on each side.
  Extent3 stored() const { return {cells_.x + 2, cells_.y + 2, cells_.z + 2}; }
  /// The row from cell (0, y, z) on. requires: -1 <= y, z <= cells. unit: 1 / 255.
  std::uint8_t* row(std::int64_t y, std::int64_t z) { return bytes() + placeOf(y, z); }
  const std::uint8_t* row(std::int64_t y, std::int64_t z) const { return bytes() + placeOf(y, z); }
  /// The stored cells, four a word.
  const std::int32_t* words() const { return words_.data(); }

 private:
  std::int64_t placeOf(std::int64_t y, std::int64_t z) const {
    return ((z + 1) * (cells_.y + 2) + y + 1) * (cells_.x + 2) + 1;
  }
  std::uint8_t* bytes() { return reinterpret_cast<std::uint8_t*>(words_.data()); }
  const std::uint8_t* bytes() const { return reinterpret_cast<const std::uint8_t*>(words_.data()); }

  Extent3 cells_;
  std::vector<std::int32_t, UnsetAllocator<std::int32_t>> words_;
};

/// A look-up of a cone: the middle of a step of `1 << level` cells.
struct ConeStep {
  float at;  // distance. unit: cells of level 0
  int level;
  float weight;  // of matter at the distance
};

struct Cones {
  std::span<const glm::vec3> directions;
  std::span<const ConeStep> steps;
  std::span<const OpenLevel> levels;
};

/// Points in the lattice. unit: cells of level 0, from the corner of the first.
struct ConePoints {
  std::vector<float> x, y, z;
  std::size_t size() const { return x.size(); }
  void add(const glm::vec3& p) { x.push_back(p.x), y.push_back(p.y), z.push_back(p.z); }
};

/// Transmittance below which a cone ends.
inline constexpr float kDarkCone = 0.02f;

/// Stores the visibility around each point. Repeats the last point until vectors are full. requires: a point.
void marchCones(const Cones& cones, ConePoints& points, std::vector<AmbientCell>& out);

}  // namespace kiln
