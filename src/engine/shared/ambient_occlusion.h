// Visibility of the surroundings around each point of the volumes, for ambient light.
// Method. A coarse grid holds the mean m of the visibility V over all directions ω, and the mean d of V ω. A surface
// with normal n sees the share m + 2 d·n of its surroundings, weighted by the cosine: the first two orders of spherical
// harmonics, exact for an open half space. A sample without a normal sees the share m.
// Source: Hernell, Ljung and Ynnerman 2010 (local ambient occlusion); Ramamoorthi and Hanrahan 2001 (irradiance by
// spherical harmonics).
// Differs: two orders; one grid for all volumes.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "base/memory/large_pages.h"
#include "grid/coords.h"

namespace kiln {

/// A cell of the grid, packed so that samples load cells as words.
struct AmbientCell {
  std::int8_t mean = kHalfOpen;  // 2 * visibility - 1
  std::int8_t along[3] = {0, 0, 0};
  static constexpr std::int8_t kHalfOpen = 127;
  static constexpr float kMean = 0.5f / kHalfOpen, kAlong = 0.25f / 127;  // units of the members
};
static_assert(sizeof(AmbientCell) == 4);

class AmbientGrid {
 public:
  // In large pages, because look-ups are scattered.
  using Cells = std::vector<AmbientCell, UnsetAllocator<AmbientCell>>;

  /// shape: `cells` in x order first; cell (i, j, k) is at grid_from_world⁻¹ (i, j, k). requires: two cells along each
  /// axis.
  AmbientGrid(const Extent3& dims, const glm::dmat4& grid_from_world, Cells cells)
      : dims_(dims), grid_from_world_(grid_from_world), cells_(std::move(cells)) {}

  const Extent3& dims() const { return dims_; }
  const glm::dmat4& gridFromWorld() const { return grid_from_world_; }
  const AmbientCell* cells() const { return cells_.data(); }

 private:
  Extent3 dims_;
  glm::dmat4 grid_from_world_;
  Cells cells_;
};

/// Ambient light of samples given in view space.
class AmbientLookup {
 public:
  /// Distance from a surface to the look-up along the normal: cells inside of matter see nothing. unit: cells.
  static constexpr float kAhead = 0.91f;

  /// No occlusion.
  AmbientLookup() = default;
  /// requires: `grid` outlives the object.
  AmbientLookup(const AmbientGrid& grid, float strength, const glm::dmat4& view_from_world);

  bool none() const { return grid_ == nullptr; }
  const AmbientGrid& grid() const { return *grid_; }
  float strength() const { return strength_; }
  const glm::mat4& gridFromView() const { return grid_from_view_; }
  const glm::mat3& turned() const { return turned_; }
  /// Returns the share of ambient light that reaches a sample. `normal`: unit vector in view space, or 0.
  float operator()(const glm::vec3& view_point, const glm::vec3& normal) const {
    return grid_ == nullptr ? 1 : share(view_point, normal);
  }

 private:
  float share(const glm::vec3& view_point, const glm::vec3& normal) const;

  const AmbientGrid* grid_ = nullptr;
  float strength_ = 0;
  glm::mat4 grid_from_view_{1};
  glm::mat3 turned_{1};  // directions of view space along the grid's axes
};

}  // namespace kiln
