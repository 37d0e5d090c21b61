#include "engine/voxel/tile_walk.h"

#include "engine/voxel/gather_voxels.h"

namespace kiln {
namespace {

// Visibility is tested once more for each eighth of a cell; the eighths are visited in the cell's own order.
static_assert(kCellSize / 2 == kSplatCellSize);

struct BlockWalk {
  const SplatContext& context;
  const BrickBlock& block;
  const TileTarget& target;
  TilePlanes& planes;
  DrawCounts& counts;
  NodeLog* log;
  const PixelRect brick_rect = context.projector->bounds(block.core);
  bool taken = false;  // the planes hold the tile's pixels

  // Visits the node of `level` that covers `box`: level 0 is a cell, depth - 1 the brick.
  void node(int level, const VoxelBox& box, const PixelRect& rect) noexcept {
    const auto at = [&](int axis) {
      return static_cast<int>(((box.lo[axis] - block.core.lo[axis]) >> level) / kCellSize);
    };
    if (!context.classifier->interesting(block.octree.at(level, at(0), at(1), at(2))) || skipped(box, rect, level))
      return;
    if (level == 0) fetch(box);
    const std::int64_t half = kCellSize << level >> 1;
    const VoxelCoord middle = {box.lo.x + half, box.lo.y + half, box.lo.z + half};
    Projector::Boxes boxes;
    for (unsigned child = 0; child < boxes.size(); ++child) {
      const auto lo = [&](int axis) { return (child >> axis & 1) != 0 ? middle[axis] : box.lo[axis]; };
      boxes[child] = cube({lo(0), lo(1), lo(2)}, half);
    }
    const Projector::Rects rects = context.projector->bounds(boxes);
    for (const std::uint8_t child : context.projector->order().children(middle)) {
      if (level > 0)
        node(level - 1, boxes[child], rects[child]);
      else
        subCell(boxes[child], rects[child]);
    }
  }

  // Prefetches all rows of a cell. Each row has its own cache line; without the prefetch the loop would wait for each
  // row in turn.
  void fetch(const VoxelBox& box) const noexcept {
    const std::size_t voxel = sizeOf(block.type);
    const std::byte* const first = block.voxels.data() + static_cast<std::size_t>(block.offsetOf(box.lo)) * voxel;
    const Extent3 count = box.extent();
    for (std::int64_t z = 0; z < count.z; ++z) {
      for (std::int64_t y = 0; y < count.y; ++y)
        __builtin_prefetch(first + static_cast<std::size_t>(z * block.strideZ() + y * block.strideY()) * voxel);
    }
  }

  void subCell(const VoxelBox& box, const PixelRect& rect) noexcept {
    if (box.empty() || skipped(box, rect, -1)) return;
    if (taken || takePixels()) splatCell(context, block, box, target, planes, counts);
  }

  // Copies all pixels of the tile that the brick's footprints can touch into the planes. Returns false if there are
  // none: the bounding spheres of a node can reach farther than the footprints.
  bool takePixels() noexcept {
    const PixelRect touched = intersection(brick_rect, target.pixels.rect);
    if (touched.empty()) return false;
    planes.take(target.pixels.of(touched));
    return taken = true;
  }

  // Returns true if no voxel of `box`, whose projection lies in `bounds`, can be visible in this tile.
  bool skipped(const VoxelBox& box, const PixelRect& bounds, int level) noexcept {
    if (context.clip->classify(box) == ClipRegion::Overlap::kOutside) return true;
    const PixelRect rect = intersection(bounds, target.pixels.rect);
    if (rect.empty()) return true;
    const bool hidden = target.visibility.hidden(rect);
    ++counts.nodes_tested;
    counts.nodes_hidden += hidden ? 1 : 0;
    if (log != nullptr) log->add(box, level, hidden);
    return hidden;
  }

  VoxelBox cube(const VoxelCoord& lo, std::int64_t edge) const noexcept {
    return intersection({lo, {lo.x + edge, lo.y + edge, lo.z + edge}}, block.core);
  }
};

}  // namespace

void walkTile(const SplatContext& context, const BrickBlock& block, const TileTarget& target, TilePlanes& planes,
              DrawCounts& counts, NodeLog* log) noexcept {
  BlockWalk walk{context, block, target, planes, counts, log};
  walk.node(block.octree.depth() - 1, block.core, walk.brick_rect);
  if (walk.taken) planes.putBack();
}

}  // namespace kiln
