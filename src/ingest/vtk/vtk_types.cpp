#include "ingest/vtk/vtk_types.h"

#include <fmt/format.h>

#include <glm/mat3x3.hpp>

#include "base/error.h"
#include "ingest/source/header_text.h"

namespace kiln {

VolumeGeometry vtkGeometry(const std::filesystem::path& path, const std::array<std::int64_t, 6>& extent, bool of_cells,
                           const glm::dvec3& origin, const glm::dvec3& spacing, const glm::dmat3& direction,
                           const SourceOptions& options) {
  constexpr std::int64_t kMost = INT32_MAX;
  if (options.spacing && direction != glm::dmat3(1.0)) refuseSpacing(path);
  const glm::dvec3 edge = options.spacing.value_or(spacing);
  VolumeGeometry out;
  std::array<std::int64_t, 3> dims{};
  std::array<glm::dvec3, 3> step;
  glm::dvec3 first = origin;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const std::int64_t lo = extent[2 * i], hi = extent[2 * i + 1];
    if (lo > hi || lo < -kMost || hi > kMost)
      throw Error(ErrorCode::kFormat, path, "", fmt::format("the extent along {} is {} to {}", "xyz"[axis], lo, hi));
    // A flat grid has one layer of cells, which VTK places at its points.
    const bool between = of_cells && lo < hi;
    dims[i] = hi - lo + (between ? 0 : 1);
    step[i] = direction[axis] * edge[axis];
    first += (static_cast<double>(lo) + (between ? 0.5 : 0.0)) * step[i];
  }
  out.dims = {dims[0], dims[1], dims[2]};
  out.world_from_index = directionsAffine(step, first);
  requireInvertible(out.world_from_index, path.string());
  return out;
}

}  // namespace kiln
