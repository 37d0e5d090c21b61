// The upper part of the one octree: from the cube over all bricks down to a brick, front to back, without what the
// transfer function, the image or what is already opaque makes pointless.
#pragma once

#include <functional>
#include <vector>

#include "frame/node_log.h"
#include "splat/classifier.h"
#include "splat/projector.h"
#include "store/store_reader.h"

namespace kiln {

struct BrickWalkCounts {
  std::uint64_t interesting = 0;  // bricks that hold something the transfer function shows
  std::uint64_t hidden = 0;       // of these, in the image but behind opaque pixels
  std::uint64_t nodes_tested = 0, nodes_hidden = 0;
};

/// A brick that may be drawn, and what of the image it can touch.
struct BrickInView {
  BrickKey key;
  PixelRect rect;
};

class BrickWalk {
 public:
  /// Ranges of every node above a brick of one level. cost: memory of 16 bytes a brick and a seventh.
  BrickWalk(const StoreReader& store, int level, const Classifier& classifier);

  /// Calls draw(key, rect) for each brick to be drawn, in front-to-back order; `rect` is what of the image it can
  /// touch. Whether a node is hidden is asked when its turn comes, so everything in front of it has been drawn. `log`
  /// may be null; it is told of the nodes above bricks, since a brick is asked about again by whoever walks its cells.
  void run(const Projector& projector, const PixelRect& image, const Visibility& visibility,
           const std::function<void(const BrickKey&, const PixelRect&)>& draw, BrickWalkCounts& counts,
           NodeLog* log) const;

  /// The bricks that `run` would draw if nothing hid anything, in its order, and its counts.
  std::vector<BrickInView> inView(const Projector& projector, const PixelRect& image, BrickWalkCounts& counts) const;

 private:
  struct Layer {
    Extent3 nodes;
    std::vector<std::uint32_t> interesting;  // bricks below the node
  };
  struct Visit;
  void node(const Visit& visit, int layer, const VoxelCoord& at) const;
  std::uint32_t interestingBelow(int layer, const VoxelCoord& at) const;
  VoxelBox voxelsOf(int layer, const VoxelCoord& at) const;

  int level_;
  std::int64_t brick_size_;
  int cell_levels_;  // from a cell up to a brick
  Extent3 dims_;
  std::vector<Layer> layers_;  // 0: the bricks; the last has one node
};

}  // namespace kiln
