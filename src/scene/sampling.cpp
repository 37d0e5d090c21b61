#include "scene/sampling.h"

namespace kiln {

int levelAtScale(const Manifest& volume, double scale) {
  std::size_t level = 0;
  while (level + 1 < volume.levels.size() &&
         volume.levels[level + 1].geometry.shortestEdge() * scale <= kMostCoarseVoxel + 1e-9)
    ++level;
  return static_cast<int>(level);
}

}  // namespace kiln
