#include "ingest/chunks/chunked_array.h"

namespace kiln {

std::int64_t placeIn(const AxisNumbers& grid, const AxisNumbers& index) {
  std::int64_t out = 0;
  for (std::size_t axis = 0; axis < grid.size(); ++axis) out = out * grid[axis] + index[axis];
  return out;
}

}  // namespace kiln
