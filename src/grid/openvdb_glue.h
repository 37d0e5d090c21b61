// Coordinates, affines and voxel types as OpenVDB has them: what reading, storing and exporting a grid must agree on.
// Internal, and not installed: it is for the .cpp files that use OpenVDB.
#pragma once

#include <blosc.h>
#include <openvdb/openvdb.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <type_traits>

#include "grid/coords.h"

namespace kiln {

/// To be called before anything else of OpenVDB's. thread: safe.
inline void initializeOpenVdb() {
  static const bool done = [] {
    openvdb::initialize();
    // Blosc has LZ4 compress the bytes of each place by themselves, 512 of a leaf, and LZ4 clears 16 KB before each.
    // All at once they take an eighth less time, and a twentieth less space: upper bytes that are alike are one match.
    blosc_set_splitmode(BLOSC_NEVER_SPLIT);
    return true;
  }();
  (void)done;
}

template <class T>
struct GridTypeFor {
  using type = openvdb::FloatGrid;
};
template <>
struct GridTypeFor<std::int32_t> {
  using type = openvdb::Int32Grid;
};
template <>
struct GridTypeFor<std::uint32_t> {
  using type = openvdb::Int64Grid;
};
template <>
struct GridTypeFor<double> {
  using type = openvdb::DoubleGrid;
};
/// The grid type that holds a voxel type exactly, and that other programs read.
template <class T>
using GridFor = typename GridTypeFor<T>::type;

/// A new grid of `background`. Made by OpenVDB's own registry: a constructor here would have every virtual function of
/// grid and tree compiled once more, half a minute a file. errors: none for the types of GridFor.
template <class Grid>
typename Grid::Ptr newGrid(typename Grid::ValueType background) {
  initializeOpenVdb();
  auto grid = openvdb::gridPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
  grid->tree().root().setBackground(background, /*updateChildNodes=*/false);
  return grid;
}

/// Whether the value comes back bit for bit from a half; false for every NaN.
inline bool survivesHalf(float value) {
  if (std::isnan(value)) return false;
  const float back = static_cast<float>(openvdb::math::half(value));
  return std::bit_cast<std::uint32_t>(value) == std::bit_cast<std::uint32_t>(back);
}

/// requires: each coordinate in 32 bits.
inline openvdb::Coord coordOf(const VoxelCoord& v) {
  return {static_cast<int>(v.x), static_cast<int>(v.y), static_cast<int>(v.z)};
}

// OpenVDB multiplies row vectors: its matrix is the transpose, which is glm's memory order read row by row.
inline openvdb::math::Transform::Ptr transformOf(const glm::dmat4& world_from_grid) {
  openvdb::Mat4d matrix;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) matrix(column, row) = world_from_grid[column][row];
  }
  return openvdb::math::Transform::createLinearTransform(matrix);
}

/// Whether OpenVDB takes it. It refuses voxels of less than 3e-15 cubic units, and edges that are lost beside an origin
/// far away.
inline bool hasTransform(const glm::dmat4& world_from_grid) {
  try {
    transformOf(world_from_grid);
    return true;
  } catch (const openvdb::ArithmeticError&) {
    return false;
  }
}

/// requires: a linear transform.
inline glm::dmat4 affineOf(const openvdb::math::Transform& transform) {
  const openvdb::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
  glm::dmat4 world_from_grid;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) world_from_grid[column][row] = matrix(column, row);
  }
  return world_from_grid;
}

}  // namespace kiln
