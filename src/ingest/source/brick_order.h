// The order in which a conversion reads bricks with their aprons. Bricks are swept along one axis, in blocks of their
// cross-section: a block of fewer bricks needs fewer decoded chunks at a time, and decodes the chunks between two
// blocks twice.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "grid/coords.h"

namespace kiln {

/// Boxes in the order of time: 0 is read first.
using ReadTime = std::int64_t;

class BrickOrder {
 public:
  static constexpr ReadTime kNever = std::numeric_limits<ReadTime>::max();

  struct Lattice {
    Extent3 dims;
    std::int64_t brick_size = 0, apron = 0;
  };
  /// Layer by layer along z, x fastest: the order of a store's index.
  explicit BrickOrder(const Lattice& lattice) : BrickOrder(lattice, 2, {1, 1}) {}
  /// `sweep` is the axis along which each block is swept; `parts` are the blocks along both other axes, the lower axis
  /// first. A block is swept layer by layer, the lower axis fastest.
  BrickOrder(const Lattice& lattice, int sweep, std::array<std::int64_t, 2> parts);

  int sweep() const { return axes_[2]; }
  /// The axes across the sweep, the lower one first.
  int across(int i) const { return axes_[i]; }
  /// Most bricks of a block across the sweep.
  std::int64_t blockEdge(int i) const { return edge_[i]; }
  /// Blocks across the sweep.
  std::int64_t blocks(int i) const { return (bricks_[i] - 1) / edge_[i] + 1; }
  bool isOneBlock() const { return blocks(0) * blocks(1) == 1; }
  bool isLayers() const { return isOneBlock() && sweep() == 2; }
  const Lattice& lattice() const { return lattice_; }

  ReadTime timeOf(const BrickCoord& brick) const;
  /// The time of the brick whose box with its apron begins at `lo`.
  ReadTime timeOfBox(const VoxelCoord& lo) const;
  /// Returns the first time after `now` at which a box that meets `voxels` is read; kNever if there is none.
  ReadTime nextUse(const VoxelBox& voxels, ReadTime now) const;

 private:
  /// A place in the order, the fastest index last: block, then brick in the block.
  struct Place {
    std::array<std::int64_t, 3> block{}, brick{};
  };
  std::int64_t edgeOf(int i, std::int64_t block) const { return std::min(edge_[i], bricks_[i] - block * edge_[i]); }
  ReadTime timeAt(const Place& place) const;
  Place placeAt(ReadTime time) const;

  Lattice lattice_;
  std::array<int, 3> axes_;             // across, across, sweep
  std::array<std::int64_t, 3> bricks_;  // along these axes
  std::array<std::int64_t, 2> edge_;    // of a block
};

/// The work of a source that decodes blocks of `shape` in this order.
struct DecodingCost {
  /// Decodings of all blocks over the number of blocks, if `blocks_kept` blocks are kept.
  double decodings = 1;
  std::uint64_t blocks_kept = 0;
};
DecodingCost decodingCost(const BrickOrder& order, const Extent3& shape);
/// Decodings without any kept block, over the number of blocks.
double decodingsUnkept(const BrickOrder::Lattice& lattice, const Extent3& shape);

/// Returns the order with the fewest decodings among those that keep at most `most_blocks`; of equal ones the order of
/// layers, then the one of the fewest kept blocks. If none fits, the order that keeps the fewest.
BrickOrder cheapestOrder(const BrickOrder::Lattice& lattice, const Extent3& shape, std::uint64_t most_blocks);

}  // namespace kiln
