#include "grid/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "base/error.h"

namespace kiln {

PatientAxes patientAxes(PatientFrame frame) {
  if (frame == PatientFrame::kRas) return {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  return {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
}

glm::dvec3 VolumeGeometry::spacing() const {
  return {glm::length(glm::dvec3(world_from_index[0])), glm::length(glm::dvec3(world_from_index[1])),
          glm::length(glm::dvec3(world_from_index[2]))};
}

double VolumeGeometry::voxelVolume() const { return std::abs(glm::determinant(glm::dmat3(world_from_index))); }

std::array<glm::dvec3, 8> VolumeGeometry::corners() const {
  std::array<glm::dvec3, 8> out;
  for (unsigned corner = 0; corner < out.size(); ++corner) {
    glm::dvec3 index(-0.5);
    for (int axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1) != 0) index[axis] += static_cast<double>(dims[axis]);
    }
    out[corner] = worldOf(index);
  }
  return out;
}

double VolumeGeometry::shortestEdge() const {
  const glm::dvec3 edges = spacing();
  return std::min({edges.x, edges.y, edges.z});
}

double VolumeGeometry::meanSpacing() const { return std::cbrt(voxelVolume()); }

bool VolumeGeometry::isUnturned() const {
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      const double entry = world_from_index[column][row];
      if (column == row ? !(entry > 0) : entry != 0) return false;
    }
  }
  return true;
}

void requireInvertible(const glm::dmat4& world_from_index, const std::string& path) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(world_from_index[column][row])) {
        throw Error(ErrorCode::kFormat, path, "geometry",
                    fmt::format("spacing, direction or origin is not a finite number (found {}); correct the header",
                                world_from_index[column][row]));
      }
    }
  }
  // The test for coplanar axes has no scale: it compares the volume of the voxel with the product of its edge lengths.
  VolumeGeometry geometry;
  geometry.world_from_index = world_from_index;
  // std::hypot, because the square of a spacing may overflow or underflow a double.
  glm::dvec3 edge;
  for (int axis = 0; axis < 3; ++axis)
    edge[axis] = std::hypot(world_from_index[axis].x, world_from_index[axis].y, world_from_index[axis].z);
  // Keeps the volume of a voxel within the range of a double.
  constexpr double kLeast = 1e-100, kMost = 1e100;
  for (int axis = 0; axis < 3; ++axis) {
    if (edge[axis] == 0 || (edge[axis] >= kLeast && edge[axis] <= kMost)) continue;
    throw Error(
        ErrorCode::kFormat, path, "geometry",
        fmt::format("a spacing must be from {:g} to {:g} world units (found {:g}); give the volume another unit",
                    kLeast, kMost, edge[axis]));
  }
  const double box = edge.x * edge.y * edge.z;
  if (!(box > 0) || !(geometry.voxelVolume() > 1e-9 * box)) {
    throw Error(ErrorCode::kFormat, path, "geometry",
                fmt::format("the three voxel axes do not span space (a spacing is zero, or directions coincide; found "
                            "spacings {:g} x {:g} x {:g}); correct the header",
                            edge.x, edge.y, edge.z));
  }
}

}  // namespace kiln
