#include "ingest/chunks/chunked_array.h"

namespace kiln {

std::uint64_t productOf(const AxisNumbers& lengths) {
  std::uint64_t out = 1;
  for (const std::int64_t length : lengths) out *= static_cast<std::uint64_t>(length);
  return out;
}

std::int64_t placeIn(const AxisNumbers& grid, const AxisNumbers& index) {
  std::int64_t out = 0;
  for (std::size_t axis = 0; axis < grid.size(); ++axis) out = out * grid[axis] + index[axis];
  return out;
}

std::shared_ptr<const BlockCache::Bytes> ChunkedArray::chunk(const AxisNumbers& index, const BlockCache::Use& use) {
  const std::int64_t place = placeIn(grid_, index);
  const auto decoded = [&](BlockCache::Bytes spare) {
    BlockCache::Bytes voxels = decode(index, place, std::move(spare));
    if (voxels.empty()) ++absent_;
    return voxels;
  };
  return cache_.get({place, 0}, decoded, use);
}

AxisNumbers gridOf(const ChunkLayout& layout) {
  AxisNumbers out;
  for (std::size_t axis = 0; axis < layout.shape.size(); ++axis)
    out.push_back((layout.shape[axis] - 1) / layout.chunk_shape[axis] + 1);
  return out;
}

}  // namespace kiln
