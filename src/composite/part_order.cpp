#include "composite/part_order.h"

#include <fmt/format.h>

#include <glm/matrix.hpp>
#include <numeric>

#include "base/error.h"

namespace kiln {
namespace {

// The view's rays in the volume's index space.
struct Rays {
  bool perspective;
  glm::dvec3 vector;  // perspective: the eye; parallel: the direction
};

Rays raysOf(const View& view, const VolumeGeometry& volume) {
  const glm::dmat4 index_from_world = glm::inverse(volume.world_from_index);
  const bool perspective = view.projection == Projection::kPerspective;
  return {perspective, perspective ? glm::dvec3(index_from_world * glm::dvec4(view.eye_world, 1))
                                   : glm::dvec3(index_from_world * glm::dvec4(view.forward_world, 0))};
}

// Returns true if a ray may pass `a` and then `b`: along every axis that separates the boxes, the ray runs from `a` to
// `b`.
bool mayHide(const VoxelBox& a, const VoxelBox& b, const Rays& rays) {
  for (int axis = 0; axis < 3; ++axis) {
    const double v = rays.vector[axis];
    if (a.hi[axis] <= b.lo[axis] && !(rays.perspective ? v < static_cast<double>(a.hi[axis]) - 0.5 : v > 0))
      return false;
    if (b.hi[axis] <= a.lo[axis] && !(rays.perspective ? v > static_cast<double>(a.lo[axis]) - 0.5 : v < 0))
      return false;
  }
  return true;
}

}  // namespace

std::optional<std::vector<int>> frontToBack(std::span<const VoxelBox> boxes, const View& view,
                                            const VolumeGeometry& volume) {
  const Rays rays = raysOf(view, volume);
  std::vector<int> left(boxes.size()), out;
  std::iota(left.begin(), left.end(), 0);
  const auto box = [&](int i) -> const VoxelBox& { return boxes[static_cast<std::size_t>(i)]; };
  while (!left.empty()) {
    const auto nearest = std::find_if(left.begin(), left.end(), [&](int i) {
      return std::none_of(left.begin(), left.end(),
                          [&](int other) { return other != i && mayHide(box(other), box(i), rays); });
    });
    if (nearest == left.end()) return std::nullopt;
    out.push_back(*nearest);
    left.erase(nearest);
  }
  return out;
}

std::vector<int> requiredOrder(std::span<const VoxelBox> boxes, const View& view, const VolumeGeometry& volume,
                               const std::filesystem::path& first) {
  std::optional<std::vector<int>> order = frontToBack(boxes, view, volume);
  if (!order)
    throw Error(ErrorCode::kUsage, first, "",
                fmt::format("there is no order of visibility among it and {} other parts, which hide one another in "
                            "turn; cut the volume by --part I/N, or by planes through all of it",
                            boxes.size() - 1));
  return *std::move(order);
}

}  // namespace kiln
