// Position of a volume in the world: extent, affine from index to world space, and patient orientation.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "grid/coords.h"

namespace kiln {

/// Patient directions of the world axes +x, +y, +z. RAS: right, anterior, superior. LPS: left, posterior, superior.
enum class PatientFrame { kUnknown, kRas, kLps };

/// World directions of a patient in a frame; an unknown frame is read as LPS. Unit length.
struct PatientAxes {
  glm::dvec3 left, anterior, superior;
};
PatientAxes patientAxes(PatientFrame frame);

struct VolumeGeometry {
  Extent3 dims;
  /// Maps index space to world space: voxel (i,j,k) is centred at world_from_index * (i,j,k,1). Any invertible affine
  /// is legal.
  glm::dmat4 world_from_index{1.0};
  PatientFrame frame = PatientFrame::kUnknown;
  /// The unit of length in the world ("mm"); empty if unknown.
  std::string unit;

  glm::dvec3 worldOf(const glm::dvec3& index) const { return glm::dvec3(world_from_index * glm::dvec4(index, 1.0)); }
  /// Corners of the box around the cubes of all voxels, from index -1/2 to N - 1/2. unit: world.
  std::array<glm::dvec3, 8> corners() const;
  /// Lengths of the three edges of a voxel. unit: world.
  glm::dvec3 spacing() const;
  /// The shortest edge of a voxel. unit: world.
  double shortestEdge() const;
  /// unit: world³.
  double voxelVolume() const;
  /// Edge of a cube of the voxel's volume: the default unit of opacity. unit: world.
  double meanSpacing() const;
  /// True if axes of voxels and world agree but for lengths: no rotation, exchange or mirroring.
  bool isUnturned() const;
};

/// throws: Error kFormat, naming `path`, if the affine has a non-finite entry or is not invertible.
void requireInvertible(const glm::dmat4& world_from_index, const std::string& path);

}  // namespace kiln
