#include "ingest/vtk/vtk_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/mat3x3.hpp>

#include "base/error.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr std::size_t kMostVtkArraysShown = 8;

std::string shortListOf(const std::vector<std::string>& texts) {
  std::string out;
  for (std::size_t i = 0; i < std::min(texts.size(), kMostVtkArraysShown); ++i) out += (i == 0 ? "" : ", ") + texts[i];
  return texts.size() > kMostVtkArraysShown ? out + " and more" : out;
}

[[noreturn]] void refuseAll(const std::vector<VtkArray>& arrays, const std::filesystem::path& path) {
  std::vector<std::string> found;
  for (const VtkArray& array : arrays)
    found.push_back(fmt::format("{} of {} x {}", inQuotes(array.name), array.components, inQuotes(array.type_text)));
  throw Error(ErrorCode::kUnsupported, path, "",
              fmt::format("holds no array of one number of 8 to 64 bits a point or cell (found {})",
                          found.empty() ? "none" : shortListOf(found)));
}

}  // namespace

VtkChoice chosenVtkArray(const std::vector<VtkArray>& arrays, const SourceOptions& options,
                         const std::filesystem::path& path) {
  std::vector<std::size_t> readable;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (!arrays[i].isReadable()) continue;
    readable.push_back(i);
    names.push_back(arrays[i].name);
  }
  if (readable.empty()) refuseAll(arrays, path);
  const auto active =
      std::find_if(readable.begin(), readable.end(), [&](std::size_t i) { return arrays[i].is_active; });
  if (options.channel || active == readable.end()) {
    const std::int64_t channel = chosenChannel(options, names, path);
    return {readable[static_cast<std::size_t>(channel)],
            partOf("channel", channel, static_cast<std::int64_t>(names.size())), ""};
  }
  const std::string name = inQuotes(arrays[*active].name);
  names.erase(names.begin() + (active - readable.begin()));
  for (std::string& other : names) other = inQuotes(other);
  return {
      *active, "",
      names.empty() ? "" : fmt::format("array {} is read, and not {}; --channel chooses", name, shortListOf(names))};
}

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
