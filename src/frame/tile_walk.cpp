#include "frame/tile_walk.h"

namespace kiln {
namespace {

struct Walk {
  const SplatFrame& frame;
  const BrickBlock& block;
  const TilePixels& tile;
  SplatCounts& counts;

  // Node (x,y,z) of `level`: 0 is a cell, depth-1 the brick.
  void node(int level, int x, int y, int z) const noexcept {
    if (!frame.classifier->interesting(block.octree.at(level, x, y, z))) return;
    const std::int64_t edge = std::int64_t{8} << level;
    const VoxelCoord lo = {block.core.lo.x + x * edge, block.core.lo.y + y * edge, block.core.lo.z + z * edge};
    const VoxelBox box = intersection({lo, {lo.x + edge, lo.y + edge, lo.z + edge}}, block.core);
    const PixelRect rect = intersection(frame.projector->bounds(box), tile.rect);
    if (rect.empty()) return;
    ++counts.nodes_tested;
    if (frame.visibility->hidden(rect)) {
      ++counts.nodes_hidden;
      return;
    }
    if (level == 0) {
      splatCell(frame, block, box, tile, counts);
      return;
    }
    const std::int64_t half = edge / 2;
    const unsigned nearest = frame.projector->order().nearestChild({lo.x + half, lo.y + half, lo.z + half});
    for (unsigned i = 0; i < 8; ++i) {
      const unsigned child = nearest ^ i;
      node(level - 1, 2 * x + static_cast<int>(child & 1), 2 * y + static_cast<int>(child >> 1 & 1),
           2 * z + static_cast<int>(child >> 2));
    }
  }
};

}  // namespace

void walkTile(const SplatFrame& frame, const BrickBlock& block, const TilePixels& tile, SplatCounts& counts) noexcept {
  Walk{frame, block, tile, counts}.node(block.octree.depth() - 1, 0, 0, 0);
}

}  // namespace kiln
