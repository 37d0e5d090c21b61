// Front-to-back traversal of a frame's octree, from the cube around all bricks down to single bricks.
// Problem. Bricks without visible values, outside the image or behind opaque pixels must be neither read nor drawn.
// Method. Each node of brick size above the finest level has a brick of its own on a coarser level. The coarse brick
// replaces the node's children if the coarse voxels are small enough. Above the coarsest level a node is a cube of
// bricks. With a single level, all nodes above bricks are such cubes.
// Invariant. Drawn bricks fill the volume without overlap (engines that decide levels by depth clip bricks to zones).
// Source: Lee and Ihm §2.4, for a single level. Differs: exact order in perspective; several levels.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/brick_selection.h"
#include "engine/shared/classifier.h"
#include "store/bricked_volume.h"
#include "traverse/frame_levels.h"
#include "traverse/node_log.h"

namespace kiln {

/// Counts of bricks at the levels required by the view. Without occlusion these bricks fill the volume without overlap.
struct BrickWalkCounts {
  std::uint64_t bricks = 0;       // all bricks, in the image or not
  std::uint64_t interesting = 0;  // bricks visible to the transfer function and the clip region
  std::uint64_t masked = 0;       // bricks that a mask hides, by its index
  std::uint64_t hidden = 0;       // interesting bricks inside the image, behind opaque pixels; counted by passes
  std::uint64_t nodes_tested = 0, nodes_hidden = 0;
  void add(const BrickWalkCounts& other) {
    bricks += other.bricks, interesting += other.interesting, masked += other.masked, hidden += other.hidden;
    nodes_tested += other.nodes_tested, nodes_hidden += other.nodes_hidden;
  }
};

/// A brick that may be drawn, and the pixels it can touch.
struct BrickInView {
  BrickKey key;
  PixelRect rect;
};

class BrickWalk {
 public:
  /// Plans the nodes of a frame. Only bricks that touch the drawn part of the volume (`Clipping::part`) are selected.
  /// requires: `store` and `levels` belong together and outlive the walk; no brick of the finest level has finer
  /// bricks. cost: 16 bytes per brick, plus a seventh.
  BrickWalk(const BrickedVolume& store, const FrameLevels& levels, BrickSelection selection);

  /// Calls draw(key, rect) for each brick to be drawn, front to back; `rect` contains the pixels of the brick. A node's
  /// visibility is tested after everything in front of it has been drawn. `log` may be null; only nodes above bricks
  /// are logged, since the traversal of a brick's cells logs the brick again.
  void run(const PixelRect& image, const Visibility& visibility,
           const std::function<void(const BrickKey&, const PixelRect&)>& draw, BrickWalkCounts& counts,
           NodeLog* log) const;

  /// Returns the bricks that `run` would draw without occlusion, in equal order, and fills `counts`.
  std::vector<BrickInView> inView(const PixelRect& image, BrickWalkCounts& counts) const;
  /// Returns true if each part of a brick in view is hidden or lies in a rectangle of `covered`.
  bool hidden(const BrickInView& brick, const Visibility& visibility, std::span<const PixelRect> covered = {}) const;

 private:
  struct Node {
    std::uint32_t bricks = 0, interesting = 0, masked = 0;  // bricks of the node and below
    bool drawn = false;                                     // the node's brick is drawn and interesting
    bool finer = false;
  };
  struct Layer {
    int level;          // level whose voxels measure the nodes
    std::int64_t edge;  // edge of a node. unit: voxels of `level`
    Extent3 children;   // children of a node along each axis: 1 or 2; children are in the layer before
    Extent3 lattice;
    std::vector<Node> nodes;
  };
  struct Visit;
  bool open(const BrickKey& key, const PixelRect& rect, const Visibility& visibility,
            std::span<const PixelRect> covered = {}) const;
  void addLayer(Layer layer);
  bool visiblePart(int level, const VoxelBox& core, const BrickEntry& entry, const RectTest& test) const;
  Node sumOfChildren(std::size_t layer, const VoxelCoord& at) const;
  const Node* find(std::size_t layer, const VoxelCoord& at) const;
  VoxelBox voxelsOf(const Layer& layer, const VoxelCoord& at) const;
  PixelRect boundsOf(const Layer& layer, const VoxelBox& voxels, const Node& node) const;
  void node(const Visit& visit, std::size_t layer, const VoxelCoord& at) const;

  const BrickedVolume& store_;
  const FrameLevels& levels_;
  const BrickSelection selection_;
  const std::int64_t brick_size_;
  std::vector<Layer> layers_;  // layer 0: bricks of the finest level; the last layer has a single node
};

/// Levels of the voxel engine: the coarsest brick whose voxels are small enough at its nearest point. requires:
/// `levels` outlives the result.
ChooseLevel voxelLevelChoice(const FrameLevels& levels);
/// Tests a brick as a single part: visible if its own voxels are. requires: `classifier` outlives the result.
VisiblePart wholeBrick(const Classifier& classifier);

}  // namespace kiln
