#include "scene/volume_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"

namespace kiln {
namespace {

// Returns the cut nearest to `share` of the way from lo to hi: between bricks, or between voxels if both ends are in
// one brick. requires: lo and hi at least two voxels apart.
std::int64_t cutAt(std::int64_t lo, std::int64_t hi, double share, std::int64_t brick_size) {
  const std::int64_t step = (hi - 1) / brick_size > lo / brick_size ? brick_size : 1;
  const double wanted = static_cast<double>(lo) + share * static_cast<double>(hi - lo);
  const auto cut = static_cast<std::int64_t>(wanted / static_cast<double>(step) + 0.5) * step;
  return std::clamp(cut, (lo / step + 1) * step, (hi - 1) / step * step);
}

}  // namespace

std::optional<PartNumber> partNumbered(std::string_view text) {
  PartNumber out;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, out.index);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '/') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, out.count);
  const bool legal = second.ec == std::errc() && second.ptr == end && out.index >= 1 && out.index <= out.count;
  return legal && out.count <= kMostParts ? std::optional(out) : std::nullopt;
}

VoxelBox boxOfPart(const PartNumber& part, const Extent3& dims, std::int64_t brick_size) {
  VoxelBox box = boxOf(dims);
  int index = part.index - 1, count = part.count;
  while (count > 1) {
    const Extent3 n = box.extent();
    const int axis = n.x >= n.y && n.x >= n.z ? 0 : n.y >= n.z ? 1 : 2;
    if (n[axis] < 2)
      throw Error(ErrorCode::kUsage, fmt::format("--part: a volume of {} x {} x {} voxels cannot be cut into {} parts",
                                                 dims.x, dims.y, dims.z, part.count));
    const int before = count / 2;
    const std::int64_t cut = cutAt(box.lo[axis], box.hi[axis], static_cast<double>(before) / count, brick_size);
    if (index < before) {
      box.hi[axis] = cut;
      count = before;
    } else {
      box.lo[axis] = cut;
      index -= before;
      count -= before;
    }
  }
  return box;
}

}  // namespace kiln
