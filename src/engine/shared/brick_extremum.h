// Greatest or least value of the linearly interpolated field along the part of a ray in a brick.
// Problem. Samples at a distance miss peaks by a part that changes from pixel to pixel: stripes where voxels are large.
// Method. Between planes through voxels' centres, the field along a ray is a cubic polynomial. Its extremum lies on one
// of the planes, at an end of the ray, or where the derivative is 0. Cells of 8³ voxels, and cubes between eight
// voxels, whose values do not exceed the value held are skipped.
// Invariant. Places follow from the ray and the level's voxels alone: bits are equal for all bricks and tiles.
// Source: Marmitt et al. 2004 (the cubic polynomial along a ray). Differs: zeros of the derivative, not of the field.
// Cost. A comparison of eight voxels for each cube on the ray (engine/projection/decisions/projections.md).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <type_traits>
#include <utility>

#include "engine/shared/brick_cells.h"
#include "engine/shared/draw_counts.h"
#include "engine/shared/index_ray.h"
#include "engine/shared/interpolated_brick.h"
#include "store/codec/brick_block.h"

namespace kiln {

/// A part of a ray in a brick, and which of its ends are ends of the ray, where the field is evaluated, too.
struct RayStretch {
  DepthSpan depths;
  bool begins, ends;
};

/// T: type of the voxels. Held values are values with the sign of the projection: every extremum is a maximum.
template <class T, bool kLeast>
class BrickExtremum {
 public:
  BrickExtremum(const BrickBlock& block, bool all, DrawCounts& counts)
      : cells_(block), field_(block), all_(all), counts_(counts) {}

  /// Raises `held` to the greatest value of the part.
  void take(const IndexRay& ray, const RayStretch& part, double& held) noexcept {
    if (part.begins) takeAt(ray, part.depths.near, held);
    if (part.ends) takeAt(ray, part.depths.far, held);
    // Steps from cell to cell of 8³ voxels.
    const glm::dvec3 base = cells_.placeOf(ray.base);
    const glm::dvec3 place = base + part.depths.near * ray.slope;
    int cell[3];
    std::array<double, 3> leaves_at;
    // The last cell of a direction reaches to the end of the part, which other operations round.
    const auto leaveAt = [&](int axis) {
      const bool forward = ray.slope[axis] > 0;
      if (ray.slope[axis] == 0 || cells_.isLast(axis, cell[axis], forward)) return kNever;
      return (BrickCells::faceBehind(cell[axis], forward) - base[axis]) / ray.slope[axis];
    };
    for (int axis = 0; axis < 3; ++axis) {
      cell[axis] = cells_.cellAt(axis, place[axis]);
      leaves_at[static_cast<std::size_t>(axis)] = leaveAt(axis);
    }
    for (double at = part.depths.near; at < part.depths.far;) {
      const auto axis = static_cast<int>(std::min_element(leaves_at.begin(), leaves_at.end()) - leaves_at.begin());
      const double leaves = std::min(leaves_at[static_cast<std::size_t>(axis)], part.depths.far);
      if (leaves > at) {
        ++counts_.nodes_tested;
        const ValueRange& range = cells_.range(cell);
        if (range.empty() || !(all_ || (kLeast ? -range.lo : range.hi) > held))
          ++counts_.nodes_hidden;
        else
          takeCell(ray, at, leaves, held);
        at = leaves;
      }
      cell[axis] += ray.slope[axis] > 0 ? 1 : -1;
      leaves_at[static_cast<std::size_t>(axis)] = leaveAt(axis);
    }
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  // The cube between eight voxels that holds a place of a ray, and the planes through which the ray leaves the cube.
  struct Cube {
    VoxelCoord voxel;       // the cube's voxel with the least coordinates
    std::int64_t plane[3];  // the next plane of voxels along each axis
    double crosses[3];      // unit: depth
    double enters;          // depth where the ray entered the cube, possibly in front of the brick
  };

  Cube cubeAt(const IndexRay& ray, double depth) const {
    Cube out{};
    out.enters = -kNever;
    for (int axis = 0; axis < 3; ++axis) {
      const double base = ray.base[axis], slope = ray.slope[axis];
      const auto voxel = static_cast<std::int64_t>(std::floor(base + depth * slope));
      out.voxel[axis] = voxel;
      out.crosses[axis] = kNever;
      if (slope == 0) continue;
      const std::int64_t step = slope > 0 ? 1 : -1;
      const auto crossing = [&](std::int64_t plane) { return (static_cast<double>(plane) - base) / slope; };
      std::int64_t plane = slope > 0 ? voxel + 1 : voxel;
      // Rounding may put a place beside a plane on the plane's other side.
      if (crossing(plane) < depth)
        plane += step;
      else if (crossing(plane - step) >= depth)
        plane -= step;
      out.plane[axis] = plane;
      out.voxel[axis] = slope > 0 ? plane - 1 : plane;
      out.crosses[axis] = crossing(plane);
      out.enters = std::max(out.enters, crossing(plane - step));
    }
    return out;
  }

  // Takes the extrema in [from, to), a part of the ray in a cell.
  void takeCell(const IndexRay& ray, double from, double to, double& held) {
    Cube cube = cubeAt(ray, from);
    const T* corner = field_.at(cube.voxel);
    for (;;) {
      const int axis = cube.crosses[0] <= cube.crosses[1] ? (cube.crosses[0] <= cube.crosses[2] ? 0 : 2)
                                                          : (cube.crosses[1] <= cube.crosses[2] ? 1 : 2);
      const double leaves = cube.crosses[axis];
      ++counts_.visited;
      if (all_ || boundAt(corner) > held) {
        ++counts_.splats;
        takeInside(ray, cube, corner, leaves, from, to, held);
        if (leaves >= from && leaves < to) {
          glm::dvec3 place = ray.at(leaves);
          place[axis] = static_cast<double>(cube.plane[axis]);
          compare(field_.valueAt(place), held);
        }
      }
      if (!(leaves < to)) return;
      const int step = ray.slope[axis] > 0 ? 1 : -1;
      cube.enters = leaves;
      cube.plane[axis] += step;
      cube.voxel[axis] += step;
      corner += step * field_.stride(axis);
      cube.crosses[axis] = (static_cast<double>(cube.plane[axis]) - ray.base[axis]) / ray.slope[axis];
    }
  }

  // Takes the extrema between the planes of a cube. A cubic polynomial follows from four of its values.
  void takeInside(const IndexRay& ray, const Cube& cube, const T* corner, double leaves, double from, double to,
                  double& held) {
    const double length = leaves - cube.enters;
    if (!(length > 0) || leaves <= from) return;
    const glm::dvec3 lo(cube.voxel.x, cube.voxel.y, cube.voxel.z);
    const glm::dvec3 begin = ray.at(cube.enters) - lo, step = (length / 3) * ray.slope;
    double f[4];
    for (int i = 0; i < 4; ++i) f[i] = field_.between(corner, begin + static_cast<double>(i) * step);
    // Coefficients of the derivative a s² + b s + c, with s from 0 to 1 through the cube.
    const double a = 13.5 * (f[3] - f[0] + 3 * (f[1] - f[2]));
    const double b = 18 * f[0] - 45 * f[1] + 36 * f[2] - 9 * f[3];
    const double c = -5.5 * f[0] + 9 * f[1] - 4.5 * f[2] + f[3];
    const double squared = b * b - 4 * a * c;
    if (!(squared >= 0)) return;
    // Both quotients are precise: no difference of nearly equal numbers.
    const double q = -0.5 * (b + std::copysign(std::sqrt(squared), b));
    for (const double s : {q / a, c / q}) {
      if (!(s > 0 && s < 1)) continue;
      const double at = cube.enters + s * length;
      if (at >= from && at < to) takeAt(ray, at, held);
    }
  }

  void takeAt(const IndexRay& ray, double depth, double& held) { compare(field_.valueAt(ray.at(depth)), held); }
  void compare(double value, double& held) {
    const double signed_value = kLeast ? -value : value;
    if (!(signed_value > held)) return;
    held = signed_value;
    counts_.changed = true;
  }

  // Greatest value of a cube's corners, with the projection's sign; NaN corners do not count.
  double boundAt(const T* corner) const {
    const std::int64_t y = field_.stride(1), z = field_.stride(2);
    if constexpr (std::is_floating_point_v<T>) {
      double out = -kNever;
      for (const T* row : {corner, corner + y, corner + z, corner + y + z}) {
        for (int i = 0; i < 2; ++i) {
          const double value = kLeast ? -static_cast<double>(row[i]) : static_cast<double>(row[i]);
          out = value > out ? value : out;
        }
      }
      return out;
    } else {
      const auto most = [](T u, T v) { return kLeast ? std::min(u, v) : std::max(u, v); };
      const auto ofRow = [&](const T* row) { return most(row[0], row[1]); };
      const T out = most(most(ofRow(corner), ofRow(corner + y)), most(ofRow(corner + z), ofRow(corner + y + z)));
      return kLeast ? -static_cast<double>(out) : static_cast<double>(out);
    }
  }

  const BrickCells cells_;
  const InterpolatedBrick<T> field_;
  const bool all_;
  DrawCounts& counts_;
};

}  // namespace kiln
