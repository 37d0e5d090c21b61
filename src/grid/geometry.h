// Where a volume is in the world: its extent, the affine from index to world space, and what the axes mean.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "grid/coords.h"

namespace kiln {

/// What +x, +y, +z of world space mean for a patient: RAS is right, anterior, superior; LPS is left, posterior,
/// superior.
enum class PatientFrame { kUnknown, kRas, kLps };

struct VolumeGeometry {
  Extent3 dims;
  /// Voxel (i,j,k) has its centre at world_from_index * (i,j,k,1). Any invertible affine is legal.
  glm::dmat4 world_from_index{1.0};
  PatientFrame frame = PatientFrame::kUnknown;
  /// The world's unit of length ("mm"); empty where the source does not say.
  std::string unit;

  glm::dvec3 worldOf(const glm::dvec3& index) const { return glm::dvec3(world_from_index * glm::dvec4(index, 1.0)); }
  /// The corners of the box around all voxels' cubes, from index -1/2 to N - 1/2. unit: world.
  std::array<glm::dvec3, 8> corners() const;
  /// The lengths of the three voxel edges. unit: world.
  glm::dvec3 spacing() const;
  /// The shortest of them. unit: world.
  double shortestEdge() const;
  /// unit: world³.
  double voxelVolume() const;
  /// The edge of the cube that has the voxel's volume: the default unit of opacity. unit: world.
  double meanSpacing() const;
};

/// throws: Error kFormat naming `path` where the affine has a non-finite entry or cannot be inverted.
void requireInvertible(const glm::dmat4& world_from_index, const std::string& path);

}  // namespace kiln
