#include "convert/slab_window.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace kiln {

std::uint64_t SlabWindow::bytesFor(const SourceInfo& info, std::int64_t slices) {
  const Extent3& dims = info.geometry.dims;
  return static_cast<std::uint64_t>(dims.x * dims.y * std::min(slices, dims.z)) * sizeOf(info.type);
}

void SlabWindow::advance(std::int64_t lo, std::int64_t hi) {
  assert(lo >= lo_ && hi >= hi_);
  const Extent3& dims = source_.info().geometry.dims;
  const std::size_t slice_bytes = static_cast<std::size_t>(dims.x * dims.y) * sizeOf(source_.info().type);
  const std::size_t kept = static_cast<std::size_t>(std::max<std::int64_t>(hi_ - lo, 0)) * slice_bytes;
  if (kept > 0) std::memmove(slices_.data(), slices_.data() + slices_.size() - kept, kept);
  slices_.resize(static_cast<std::size_t>(hi - lo) * slice_bytes);
  const std::int64_t first_new = std::max(lo, hi_);
  if (first_new < hi) source_.read({{0, 0, first_new}, {dims.x, dims.y, hi}}, std::span(slices_).subspan(kept));
  lo_ = lo;
  hi_ = hi;
}

void SlabWindow::copy(const VoxelBox& box, std::span<std::byte> out) const {
  assert(box.lo.z >= lo_ && box.hi.z <= hi_);
  const Extent3& dims = source_.info().geometry.dims;
  const std::size_t voxel = sizeOf(source_.info().type);
  const std::size_t row = static_cast<std::size_t>(box.hi.x - box.lo.x) * voxel;
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, to += row) {
      const std::int64_t at = ((z - lo_) * dims.y + y) * dims.x + box.lo.x;
      std::memcpy(to, slices_.data() + static_cast<std::size_t>(at) * voxel, row);
    }
  }
}

}  // namespace kiln
