// Converts coordinates, affines and voxel types to OpenVDB's types, for the files that read, store and export grids.
// Internal and not installed: only .cpp files that use OpenVDB include this header.
#pragma once

#include <blosc.h>
#include <openvdb/openvdb.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <new>
#include <type_traits>

#include "grid/coords.h"

namespace kiln {

/// Checks that the system gives `bytes`, before a library allocates them without a check. Untouched pages cost nothing.
/// throws: std::bad_alloc.
inline void requireMemory(std::size_t bytes) { ::operator delete(::operator new(bytes)); }

/// Initializes OpenVDB. requires: called before any other use of OpenVDB. thread: safe. throws: std::bad_alloc.
inline void initializeOpenVdb() {
  static const bool done = [] {
    // blosc_init writes into a context whose allocation it does not check.
    constexpr std::size_t kContexts_bytes = std::size_t{1} << 20;
    requireMemory(kContexts_bytes);
    openvdb::initialize();
    // In split mode Blosc compresses each byte position of a leaf separately (512 bytes), and LZ4 clears 16 KB before
    // each piece. Without splitting, compression takes an eighth less time and a twentieth less space: equal upper
    // bytes become one match.
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
/// The grid type that holds a voxel type exactly and that other programs can read.
template <class T>
using GridFor = typename GridTypeFor<T>::type;

/// Makes a grid by OpenVDB's registry. A constructor call here would instantiate every virtual function of grid and
/// tree again: half a minute of compilation per file. Cannot fail for the types of GridFor.
template <class Grid>
typename Grid::Ptr newGrid(typename Grid::ValueType background) {
  initializeOpenVdb();
  auto grid = openvdb::gridPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
  grid->tree().root().setBackground(background, /*updateChildNodes=*/false);
  return grid;
}

/// True if the value survives a round trip through half bit for bit; false for every NaN.
inline bool survivesHalf(float value) {
  if (std::isnan(value)) return false;
  const float back = static_cast<float>(openvdb::math::half(value));
  return std::bit_cast<std::uint32_t>(value) == std::bit_cast<std::uint32_t>(back);
}

/// requires: each coordinate fits 32 bits.
inline openvdb::Coord coordOf(const VoxelCoord& v) {
  return {static_cast<int>(v.x), static_cast<int>(v.y), static_cast<int>(v.z)};
}

// OpenVDB multiplies row vectors, so its matrix is the transpose: glm's columns become rows.
inline openvdb::math::Transform::Ptr transformOf(const glm::dmat4& world_from_grid) {
  openvdb::Mat4d matrix;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) matrix(column, row) = world_from_grid[column][row];
  }
  return openvdb::math::Transform::createLinearTransform(matrix);
}

/// True if OpenVDB accepts the affine. OpenVDB rejects voxels below 3e-15 cubic units, and edges lost to rounding
/// beside a distant origin.
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
