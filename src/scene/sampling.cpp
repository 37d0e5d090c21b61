#include "scene/sampling.h"

namespace kiln {

int levelAtScale(const Manifest& volume, double scale, bool finest) {
  std::size_t level = 0;
  while (level + 1 < volume.levels.size() &&
         volume.levels[level + 1].geometry.shortestEdge() * scale <= kMostCoarseVoxel + 1e-9)
    ++level;
  if (finest && level > 0 && volume.levels[level - 1].geometry.dims.count() <= kMostOversampledVoxels) --level;
  return static_cast<int>(level);
}

}  // namespace kiln
