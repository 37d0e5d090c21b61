#include "ingest/source/brick_order.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace kiln {
namespace {

using IndexTriple = std::array<std::int64_t, 3>;

// Returns the first triple behind `at`, in lexicographic order, with each number in [lo, hi]; nothing if there is none.
std::optional<IndexTriple> successor(const IndexTriple& at, const IndexTriple& lo, const IndexTriple& hi) {
  // The number at `i` grows and the later numbers begin anew, or all of them begin at an `at` below the range.
  for (std::size_t i = 3; i-- > 0;) {
    bool inside = true;
    for (std::size_t k = 0; k < i; ++k) inside = inside && at[k] >= lo[k] && at[k] <= hi[k];
    if (!inside || at[i] >= hi[i]) continue;
    IndexTriple out = lo;
    std::copy_n(at.begin(), i, out.begin());
    out[i] = std::max(at[i] + 1, lo[i]);
    return out;
  }
  return std::nullopt;
}

// Indices [first, last] of bricks or blocks along an axis.
struct IndexSpan {
  std::int64_t first = 0, last = 0;
  std::int64_t count() const { return last - first + 1; }
};

// The bricks whose voxels with the apron meet [lo, hi).
IndexSpan bricksAround(const BrickOrder::Lattice& lattice, int axis, std::int64_t lo, std::int64_t hi) {
  const std::int64_t size = lattice.brick_size, bricks = (lattice.dims[axis] - 1) / size + 1;
  return {std::max<std::int64_t>(lo - lattice.apron, 0) / size,
          std::min((std::min(hi, lattice.dims[axis]) + lattice.apron - 1) / size, bricks - 1)};
}

// The blocks of length `edge` that the bricks [first, last] with their apron meet.
IndexSpan blocksUnder(const BrickOrder::Lattice& lattice, int axis, const IndexSpan& bricks, std::int64_t edge) {
  const std::int64_t lo = std::max<std::int64_t>(bricks.first * lattice.brick_size - lattice.apron, 0);
  const std::int64_t hi = std::min((bricks.last + 1) * lattice.brick_size + lattice.apron, lattice.dims[axis]);
  return {lo / edge, (hi - 1) / edge};
}

std::int64_t blocksAlong(const BrickOrder::Lattice& lattice, int axis, std::int64_t edge) {
  return (lattice.dims[axis] - 1) / edge + 1;
}

std::int64_t bricksAlongAxis(const BrickOrder::Lattice& lattice, int axis) {
  return (lattice.dims[axis] - 1) / lattice.brick_size + 1;
}

// Blocks under groups of `edge` bricks along an axis: of all groups, and of the largest group.
struct GroupBlocks {
  std::int64_t sum = 0, most = 0;
};
GroupBlocks groupBlocks(const BrickOrder::Lattice& lattice, int axis, std::int64_t edge, std::int64_t block) {
  GroupBlocks out;
  const std::int64_t bricks = bricksAlongAxis(lattice, axis);
  for (std::int64_t first = 0; first < bricks; first += edge) {
    const std::int64_t count = blocksUnder(lattice, axis, {first, std::min(first + edge, bricks) - 1}, block).count();
    out.sum += count;
    out.most = std::max(out.most, count);
  }
  return out;
}

// Layers of blocks by the layers of bricks that use them, seen from one layer of bricks.
struct LayerBlocks {
  std::int64_t through = 0;  // used before and behind
  std::int64_t old = 0, fresh = 0, single = 0;
};

// Returns the most blocks that must be kept in a sweep, for `area` blocks across it, of which `front` are begun and not
// finished at a time. Blocks that a layer of bricks uses last make room for those that it uses first.
std::uint64_t mostKept(const BrickOrder::Lattice& lattice, int axis, std::int64_t block, std::int64_t area,
                       std::int64_t front) {
  std::vector<LayerBlocks> layers(static_cast<std::size_t>(bricksAlongAxis(lattice, axis)));
  for (std::int64_t i = 0; i < blocksAlong(lattice, axis, block); ++i) {
    const IndexSpan users = bricksAround(lattice, axis, i * block, (i + 1) * block);
    const auto at = [&](std::int64_t layer) -> LayerBlocks& { return layers[static_cast<std::size_t>(layer)]; };
    if (users.count() == 1) {
      ++at(users.first).single;
      continue;
    }
    ++at(users.first).fresh;
    ++at(users.last).old;
    for (std::int64_t layer = users.first + 1; layer < users.last; ++layer) ++at(layer).through;
  }
  std::int64_t most = 0;
  for (const LayerBlocks& layer : layers)
    most = std::max(most, (layer.through + std::max(layer.old, layer.fresh)) * area +
                              (std::min(layer.old, layer.fresh) + layer.single) * front);
  return static_cast<std::uint64_t>(most);
}

}  // namespace

BrickOrder::BrickOrder(const Lattice& lattice, int sweep, std::array<std::int64_t, 2> parts)
    : lattice_(lattice), axes_{sweep == 0 ? 1 : 0, sweep == 2 ? 1 : 2, sweep} {
  for (std::size_t i = 0; i < 3; ++i) bricks_[i] = bricksAlongAxis(lattice, axes_[i]);
  for (std::size_t i = 0; i < 2; ++i) edge_[i] = (bricks_[i] - 1) / std::min(parts[i], bricks_[i]) + 1;
}

ReadTime BrickOrder::timeAt(const Place& place) const {
  const std::int64_t v = place.block[1], u = place.block[2], height = edgeOf(1, v), width = edgeOf(0, u);
  const std::int64_t before = v * edge_[1] * bricks_[0] + u * edge_[0] * height;
  return before * bricks_[2] + (place.brick[0] * height + place.brick[1]) * width + place.brick[2];
}

BrickOrder::Place BrickOrder::placeAt(ReadTime time) const {
  Place out;
  const std::int64_t of_row = edge_[1] * bricks_[0] * bricks_[2];
  out.block[1] = time / of_row;
  const std::int64_t height = edgeOf(1, out.block[1]), of_block = edge_[0] * height * bricks_[2];
  const std::int64_t in_row = time - out.block[1] * of_row;
  out.block[2] = in_row / of_block;
  const std::int64_t width = edgeOf(0, out.block[2]), in_block = in_row - out.block[2] * of_block;
  out.brick = {in_block / (width * height), in_block / width % height, in_block % width};
  return out;
}

ReadTime BrickOrder::timeOf(const BrickCoord& brick) const {
  const VoxelCoord at = {brick.x, brick.y, brick.z};
  const std::int64_t u = at[axes_[0]], v = at[axes_[1]];
  return timeAt({{0, v / edge_[1], u / edge_[0]}, {at[axes_[2]], v % edge_[1], u % edge_[0]}});
}

ReadTime BrickOrder::timeOfBox(const VoxelCoord& lo) const {
  const auto along = [&](int axis) {
    const std::int64_t brick = lo[axis] == 0 ? 0 : (lo[axis] + lattice_.apron) / lattice_.brick_size;
    return static_cast<std::int32_t>(std::min(brick, bricksAlongAxis(lattice_, axis) - 1));
  };
  return timeOf({along(0), along(1), along(2)});
}

ReadTime BrickOrder::nextUse(const VoxelBox& voxels, ReadTime now) const {
  IndexSpan bricks[3];
  for (int i = 0; i < 3; ++i) bricks[i] = bricksAround(lattice_, axes_[i], voxels.lo[axes_[i]], voxels.hi[axes_[i]]);
  const IndexSpan &u = bricks[0], &v = bricks[1], &along = bricks[2];
  const IndexTriple first_block = {0, v.first / edge_[1], u.first / edge_[0]},
                    last_block = {0, v.last / edge_[1], u.last / edge_[0]};
  // The bricks of a block around the voxels.
  const auto lowest = [&](const IndexTriple& block) {
    return IndexTriple{along.first, std::max(v.first - block[1] * edge_[1], std::int64_t{0}),
                       std::max(u.first - block[2] * edge_[0], std::int64_t{0})};
  };
  const auto highest = [&](const IndexTriple& block) {
    return IndexTriple{along.last, std::min(v.last - block[1] * edge_[1], edgeOf(1, block[1]) - 1),
                       std::min(u.last - block[2] * edge_[0], edgeOf(0, block[2]) - 1)};
  };
  const Place at = placeAt(now);
  const bool meets = at.block[1] >= first_block[1] && at.block[1] <= last_block[1] && at.block[2] >= first_block[2] &&
                     at.block[2] <= last_block[2];
  if (meets) {
    if (const auto next = successor(at.brick, lowest(at.block), highest(at.block))) return timeAt({at.block, *next});
  }
  const auto block = successor(at.block, first_block, last_block);
  return block ? timeAt({*block, lowest(*block)}) : kNever;
}

DecodingCost decodingCost(const BrickOrder& order, const Extent3& shape) {
  const BrickOrder::Lattice& lattice = order.lattice();
  const int u = order.across(0), v = order.across(1), s = order.sweep();
  const GroupBlocks of_u = groupBlocks(lattice, u, order.blockEdge(0), shape[u]),
                    of_v = groupBlocks(lattice, v, order.blockEdge(1), shape[v]);
  const std::int64_t row_u = groupBlocks(lattice, u, 1, shape[u]).most,
                     row_v = groupBlocks(lattice, v, 1, shape[v]).most;
  const std::int64_t front = order.blockEdge(1) == 1 ? row_u * row_v : of_u.most * row_v;
  DecodingCost out;
  out.blocks_kept = mostKept(lattice, s, shape[s], of_u.most * of_v.most, front);
  out.decodings = static_cast<double>(of_u.sum) / static_cast<double>(blocksAlong(lattice, u, shape[u])) *
                  static_cast<double>(of_v.sum) / static_cast<double>(blocksAlong(lattice, v, shape[v]));
  return out;
}

double decodingsUnkept(const BrickOrder::Lattice& lattice, const Extent3& shape) {
  double out = 1;
  for (int axis = 0; axis < 3; ++axis)
    out *= static_cast<double>(groupBlocks(lattice, axis, 1, shape[axis]).sum) /
           static_cast<double>(blocksAlong(lattice, axis, shape[axis]));
  return out;
}

BrickOrder cheapestOrder(const BrickOrder::Lattice& lattice, const Extent3& shape, std::uint64_t most_blocks) {
  constexpr std::int64_t kMostParts = 32;
  BrickOrder best(lattice), smallest = best;
  DecodingCost of_best = decodingCost(best, shape), of_smallest = of_best;
  bool fits = of_best.blocks_kept <= most_blocks;
  for (const int sweep : {2, 1, 0}) {
    const std::int64_t most_u = std::min(kMostParts, bricksAlongAxis(lattice, sweep == 0 ? 1 : 0)),
                       most_v = std::min(kMostParts, bricksAlongAxis(lattice, sweep == 2 ? 1 : 2));
    for (std::int64_t u = 1; u <= most_u; ++u) {
      for (std::int64_t v = 1; v <= most_v; ++v) {
        const BrickOrder order(lattice, sweep, {u, v});
        const DecodingCost cost = decodingCost(order, shape);
        if (cost.blocks_kept < of_smallest.blocks_kept) smallest = order, of_smallest = cost;
        if (cost.blocks_kept > most_blocks) continue;
        const bool better =
            !fits || cost.decodings < of_best.decodings ||
            (cost.decodings == of_best.decodings && cost.blocks_kept < of_best.blocks_kept && !best.isLayers());
        if (better) best = order, of_best = cost, fits = true;
      }
    }
  }
  return fits ? best : smallest;
}

}  // namespace kiln
