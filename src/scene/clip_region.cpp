#include "scene/clip_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <span>
#include <string>

#include "base/error.h"
#include "grid/point_bounds.h"

namespace kiln {
namespace {

std::string voxelText(const VoxelCoord& v) {
  return std::to_string(v.x) + "," + std::to_string(v.y) + "," + std::to_string(v.z);
}

void requireVoxels(const char* what, const VoxelBox& region, const Extent3& dims) {
  if (!intersection(region, boxOf(dims)).empty()) return;
  throw Error(ErrorCode::kUsage,
              std::string("the ") + what + " from " + voxelText(region.lo) + " to " + voxelText(region.hi) +
                  " (half-open) holds none of the volume's voxels, 0,0,0 to " + voxelText({dims.x, dims.y, dims.z}));
}

// False for a face that is seen edge-on: its normal, turned to the eye, may point into the matter.
bool facesEye(const glm::dvec3& inwards, const glm::dvec3& to_eye) {
  const double along = glm::dot(inwards, to_eye);
  return along <= -ClipRegion::kEdgeOn * std::sqrt(glm::dot(inwards, inwards) * glm::dot(to_eye, to_eye));
}

}  // namespace

std::vector<ClipPlane> facesOf(const glm::dvec3& lo, const glm::dvec3& hi) {
  std::vector<ClipPlane> out;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 along(0);
    along[axis] = 1;
    out.push_back({along, -lo[axis]});
    out.push_back({-along, hi[axis]});
  }
  return out;
}

void requireWorldBox(const Clipping& clipping, const VolumeGeometry& volume) {
  const std::span<const ClipPlane> faces = std::span(clipping.planes).first(clipping.box_faces);
  PointBounds box;
  bool outside = false;
  for (const ClipPlane& face : faces) {
    double most = -std::numeric_limits<double>::infinity();
    for (const glm::dvec3& corner : volume.corners()) {
      box.add(corner);
      most = std::max(most, glm::dot(face.normal, corner) + face.offset);
    }
    outside = outside || most < 0;
  }
  if (!outside) return;
  throw Error(
      ErrorCode::kUsage,
      fmt::format("--world-region (worldRegion of a job): holds nothing of the volume, which is from {:.6g},{:.6g},"
                  "{:.6g} to {:.6g},{:.6g},{:.6g} in world units; --region takes voxels",
                  box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z));
}

ClipRegion::ClipRegion(const Clipping& clipping, const VolumeGeometry& finest, const Extent3& span) {
  if (clipping.region) {
    const VoxelBox& region = *clipping.region;
    requireVoxels("region", region, finest.dims);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 along(0);
      along[axis] = 1;
      if (region.lo[axis] > 0)
        half_spaces_.push_back(halfSpace(along, 0.5 - static_cast<double>(region.lo[axis]), 0, span));
      if (region.hi[axis] < finest.dims[axis])
        half_spaces_.push_back(halfSpace(-along, static_cast<double>(region.hi[axis]) - 0.5,
                                         std::numeric_limits<double>::denorm_min(), span));
    }
  }
  if (clipping.part) {
    const VoxelBox& part = *clipping.part;
    requireVoxels("part", part, finest.dims);
    for (int axis = 0; axis < 3; ++axis) {
      const auto plane = [&](std::int64_t voxel) {
        return static_cast<double>(voxel) / static_cast<double>(span[axis]) - 0.5;
      };
      if (part.lo[axis] > 0) part_.lo[axis] = plane(part.lo[axis]);
      if (part.hi[axis] < finest.dims[axis]) part_.hi[axis] = plane(part.hi[axis]);
    }
  }
  for (const ClipPlane& plane : clipping.planes) {
    const double length = glm::length(plane.normal);
    const glm::dvec3 normal = plane.normal / length;
    half_spaces_.push_back(halfSpace(glm::transpose(glm::dmat3(finest.world_from_index)) * normal,
                                     glm::dot(normal, glm::dvec3(finest.world_from_index[3])) + plane.offset / length,
                                     0, span));
  }
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 along(0);
    along[axis] = 1;
    const double end = static_cast<double>(finest.dims[axis]) - 0.5;
    border_.push_back(halfSpace(along, 0.5, 0, span));
    border_.push_back(halfSpace(-along, end, 0, span));
    core_lo_[axis] = 0.5;
    core_hi_[axis] = static_cast<double>(finest.dims[axis]) / static_cast<double>(span[axis]) - 1.5;
  }
}

// `normal` and `offset` are in the index space of level 0; voxel p of this level is at span·p + (span - 1)/2.
ClipRegion::HalfSpace ClipRegion::halfSpace(const glm::dvec3& normal, double offset, double least,
                                            const Extent3& span) {
  const glm::dvec3 scale(span.x, span.y, span.z);
  HalfSpace out;
  out.normal = scale * normal;
  out.offset = offset + glm::dot(normal, 0.5 * (scale - 1.0));
  out.least = least;
  out.voxel = std::abs(out.normal.x) + std::abs(out.normal.y) + std::abs(out.normal.z);
  out.gradient = glm::vec3(glm::normalize(out.normal));
  return out;
}

VoxelBox ClipRegion::Part::voxels() const noexcept {
  // Beyond any volume; sums with a volume's size stay in range.
  constexpr double kFar = 1e15;
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = static_cast<std::int64_t>(std::ceil(std::max(lo[axis], -kFar)));
    out.hi[axis] = static_cast<std::int64_t>(std::ceil(std::min(hi[axis], kFar)));
  }
  return out;
}

bool ClipRegion::Part::touches(const VoxelBox& voxels) const noexcept {
  for (int axis = 0; axis < 3; ++axis) {
    if (static_cast<double>(voxels.hi[axis]) - 0.5 <= lo[axis] ||
        static_cast<double>(voxels.lo[axis]) - 0.5 >= hi[axis])
      return false;
  }
  return true;
}

std::vector<glm::dvec4> ClipRegion::halfSpaces() const {
  std::vector<glm::dvec4> out;
  for (const HalfSpace& h : half_spaces_) out.emplace_back(h.normal, h.offset - h.least);
  return out;
}

std::vector<ClipRegion::Face> ClipRegion::faces() const {
  std::vector<Face> out;
  for (const HalfSpace& h : half_spaces_) out.push_back({glm::dvec4(h.normal, h.offset), true, h.least > 0});
  for (const HalfSpace& h : border_) out.push_back({glm::dvec4(h.normal, h.offset), false, false});
  return out;
}

bool ClipRegion::contains(const glm::dvec3& index) const noexcept {
  for (const HalfSpace& h : half_spaces_) {
    if (!(glm::dot(h.normal, index) + h.offset >= h.least)) return false;
  }
  return true;
}

void ClipRegion::cutLine(const glm::dvec3& base, const glm::dvec3& slope, double& lo, double& hi) const noexcept {
  for (const HalfSpace& h : half_spaces_) {
    const double at_base = glm::dot(h.normal, base) + h.offset - h.least, change = glm::dot(h.normal, slope);
    if (change == 0 && at_base < 0) hi = lo;
    if (change > 0) lo = std::max(lo, -at_base / change);
    if (change < 0) hi = std::min(hi, -at_base / change);
  }
}

ClipRegion::Overlap ClipRegion::classify(const VoxelBox& voxels) const noexcept {
  const glm::dvec3 lo = glm::dvec3(voxels.lo.x, voxels.lo.y, voxels.lo.z) - 0.5;
  const glm::dvec3 hi = glm::dvec3(voxels.hi.x, voxels.hi.y, voxels.hi.z) - 0.5;
  Overlap out = Overlap::kInside;
  for (const HalfSpace& h : half_spaces_) {
    // Values of the half-space at the corner farthest inside and at the corner farthest outside.
    double most = h.offset, least = h.offset;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = h.normal[axis] * lo[axis], b = h.normal[axis] * hi[axis];
      most += std::max(a, b);
      least += std::min(a, b);
    }
    if (!(most >= h.least)) return Overlap::kOutside;
    if (!(least >= h.voxel)) out = Overlap::kCut;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (lo[axis] < core_lo_[axis] || hi[axis] > core_hi_[axis]) out = Overlap::kCut;
  }
  return out;
}

void ClipRegion::Nearest::compare(const std::vector<HalfSpace>& faces, const glm::dvec3& index,
                                  const glm::dvec3& to_eye) noexcept {
  for (const HalfSpace& h : faces) {
    if (!facesEye(h.normal, to_eye)) continue;
    const double inside = glm::dot(h.normal, index) + h.offset, here = inside / -glm::dot(h.normal, to_eye);
    if (!(here < distance)) continue;
    distance = here;
    gradient = inside < h.voxel ? &h.gradient : nullptr;
  }
}

const glm::vec3* ClipRegion::cutGradient(const glm::dvec3& index, const glm::dvec3& to_eye) const noexcept {
  Nearest out;
  out.compare(half_spaces_, index, to_eye);
  const bool near_border = glm::any(glm::lessThan(index, core_lo_)) || glm::any(glm::greaterThan(index, core_hi_));
  if (near_border || !half_spaces_.empty()) out.compare(border_, index, to_eye);
  return out.gradient;
}

}  // namespace kiln
