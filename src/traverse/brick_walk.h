// The upper part of the one octree: from the cube over all bricks down to a brick, front to back, without what the
// transfer function, the image or what is already opaque makes pointless. Every node down to brick size of a frame's
// finest level has a brick of its own, of a coarser level, and is drawn as that where its voxels are small enough;
// above the coarsest level, nodes are cubes of its bricks. With one level all nodes above bricks are such cubes, which
// is Lee and Ihm's octree.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/shared/classifier.h"
#include "store/store_reader.h"
#include "traverse/frame_levels.h"
#include "traverse/node_log.h"

namespace kiln {

/// Bricks at the levels that the view asks for, as if nothing hid anything: they fill the volume without overlap.
struct BrickWalkCounts {
  std::uint64_t bricks = 0;       // all of them, in the image or not
  std::uint64_t interesting = 0;  // of these, with something below that the transfer function and the clip region show
  std::uint64_t hidden = 0;       // of the interesting, in the image but behind opaque pixels
  std::uint64_t nodes_tested = 0, nodes_hidden = 0;
};

/// A brick that may be drawn, and what of the image it can touch.
struct BrickInView {
  BrickKey key;
  PixelRect rect;
};

class BrickWalk {
 public:
  /// What a frame does with a brick of a level that has the voxels of `box`.
  struct Use {
    bool itself = false;  // it is drawn
    bool finer = false;   // those below it are, before it
  };
  using Choice = std::function<Use(int level, const VoxelBox& box)>;
  /// Whether any part of a brick with the voxels of `core` is interesting and passes the test, which is told what of
  /// the plane of the image the part can touch, and perhaps more.
  using RectTest = std::function<bool(const PixelRect&)>;
  using VisiblePart =
      std::function<bool(int level, const VoxelBox& core, const BrickEntry& entry, const RectTest& test)>;

  /// requires: `store` and `levels`, which are of this store, outlive this; no brick of the finest level has finer
  /// ones. What is drawn of a brick reaches at most `ghosts` voxels beyond its own voxels' footprints. cost: memory of
  /// 12 bytes a brick and a seventh.
  BrickWalk(const StoreReader& store, const FrameLevels& levels, const Choice& choice, VisiblePart any_part,
            std::int64_t ghosts = 0);

  /// Calls draw(key, rect) for each brick to be drawn, in front-to-back order; `rect` is what of the image it can
  /// touch. Whether a node is hidden is asked when its turn comes, so everything in front of it has been drawn. `log`
  /// may be null; it is told of the nodes above bricks, since a brick is asked about again by whoever walks its cells.
  void run(const PixelRect& image, const Visibility& visibility,
           const std::function<void(const BrickKey&, const PixelRect&)>& draw, BrickWalkCounts& counts,
           NodeLog* log) const;

  /// The bricks that `run` would draw if nothing hid anything, in its order, and its counts.
  std::vector<BrickInView> inView(const PixelRect& image, BrickWalkCounts& counts) const;
  /// Whether each part of a brick in view is hidden, or lies in one of `covered`.
  bool hidden(const BrickInView& brick, const Visibility& visibility, std::span<const PixelRect> covered = {}) const;

 private:
  struct Node {
    std::uint32_t bricks = 0, interesting = 0;  // drawn for this node: itself and those below
    bool drawn = false;                         // as a brick that is interesting
    bool finer = false;
  };
  struct Layer {
    int level;          // whose voxels the nodes are boxes of
    std::int64_t edge;  // of a node. unit: voxels of that level
    Extent3 children;   // of a node, along each axis: 1 or 2; the layer before has them
    Extent3 lattice;
    std::vector<Node> nodes;
  };
  struct Visit;
  enum class Seen { kOpen, kHidden, kOutside };
  Seen seen(const BrickKey& key, const PixelRect& rect, const Visibility& visibility,
            std::span<const PixelRect> covered = {}) const;
  void addLayer(Layer layer, const Choice& choice);
  Node sumOfChildren(std::size_t layer, const VoxelCoord& at) const;
  const Node* find(std::size_t layer, const VoxelCoord& at) const;
  VoxelBox voxelsOf(const Layer& layer, const VoxelCoord& at) const;
  PixelRect boundsOf(const Layer& layer, const VoxelBox& voxels, const Node& node) const;
  void node(const Visit& visit, std::size_t layer, const VoxelCoord& at) const;

  const StoreReader& store_;
  const FrameLevels& levels_;
  const VisiblePart any_part_;
  std::int64_t brick_size_, ghosts_;
  std::vector<Layer> layers_;  // 0: the bricks of the finest level; the last has one node
};

/// The choice of the voxel lattice: the coarsest brick whose voxels are small enough where it is nearest. requires:
/// `levels` outlives the result.
BrickWalk::Choice voxelChoice(const FrameLevels& levels);
/// The brick as one part: whether its own voxels show anything. requires: `classifier` outlives the result.
BrickWalk::VisiblePart wholeBrick(const Classifier& classifier);

}  // namespace kiln
