#include "convert/plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "cluster/ranks.h"
#include "convert/pyramid/half_brick.h"
#include "convert/pyramid/half_brick_store.h"
#include "convert/stream/forward_window.h"
#include "grid/pyramid.h"
#include "ingest/bytes/block_cache.h"
#include "store/brick_index.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

std::uint64_t usefulLanes(const VolumeSource& source) {
  // One inflating thread keeps a few lanes busy; more lanes would take memory from the window, and wait.
  constexpr std::uint64_t kLanesOfStream = 8;
  const std::uint64_t threads = ThreadLimit::active();
  return source.order() == ReadOrder::kForward ? std::min(threads, kLanesOfStream) : threads;
}

// Returns the number of voxels of a brick and the apron.
std::uint64_t brickVoxels(const SourceInfo& info, const ConvertOptions& options) {
  const std::int64_t padded = options.brick_size + 2 * kApron;
  std::uint64_t out = 1;
  for (int axis = 0; axis < 3; ++axis) out *= static_cast<std::uint64_t>(std::min(padded, info.geometry.dims[axis]));
  return out;
}

// Upper bound for a brick's file, if nothing compresses. OpenVDB's upper nodes have masks of 54 KiB in any file.
// unit: bytes.
std::uint64_t fileBytes(const SourceInfo& info, const ConvertOptions& options) {
  constexpr std::uint64_t kNodes = 56 << 10;
  return kNodes + brickVoxels(info, options) * (sizeOf(info.type) < 4 ? 4 : 8);
}

std::uint64_t allSubRangesBytes(const SourceInfo& info, const ConvertOptions& options) {
  return brickCountOf(info, options) * BrickIndex::subRangesBytes(subBricksOf(options.brick_size));
}

// A brick is sent to other ranks in pieces of the half brick, overlapping by an apron; meanwhile a piece is being
// received.
std::uint64_t givenBytes(const SourceInfo& info, const ConvertOptions& options) {
  if (options.ranks == nullptr || options.ranks->alone()) return 0;
  const Extent3 by = halvingOf(info.geometry);
  const std::int64_t edge = options.brick_size;
  return 2 * HalfBrick::bytesOf({edge / by.x, edge / by.y, edge / by.z}, sizeOf(info.type));
}

// The counts by value, and four times the ranges of a brick's cells: of the brick, of the bricks below, and packed for
// the file. The cells form a cube even in a thin volume.
std::uint64_t otherBytes(const ConvertOptions& options) {
  constexpr std::uint64_t kCounts = 1 << 19, kLeast = 1 << 20;
  const auto along = static_cast<std::uint64_t>(options.brick_size / kCellSize);
  return std::max(kLeast, kCounts + 4 * along * along * along * sizeof(ValueRange));
}

// A lane holds: the box as read or assembled from parts, a part, the brick's grids (as large as its file), the file,
// and the counts and ranges.
std::uint64_t laneBytes(const SourceInfo& info, const ConvertOptions& options) {
  return brickVoxels(info, options) * 3 * sizeOf(info.type) + 2 * fileBytes(info, options) +
         2 * givenBytes(info, options) + otherBytes(options);
}

// Plans as many slices as lanes can use: the layer of bricks in the making, and the layer behind it.
void planWindow(ConversionPlan& plan, const VolumeSource& source, const ConvertOptions& options) {
  const SourceInfo& info = source.info();
  const std::int64_t least = ForwardWindow::slicesOfLayer(info.geometry.dims, options.brick_size);
  const std::int64_t best = std::min(least + options.brick_size, info.geometry.dims.z);
  const std::uint64_t other_bytes =
      plan.source_bytes + source.decodeBytes() + usefulLanes(source) * plan.lane_bytes + plan.index_bytes;
  const std::uint64_t left_bytes = options.memory_bytes - std::min(other_bytes, options.memory_bytes);
  const auto fitting = static_cast<std::int64_t>(left_bytes / sliceBytes(info));
  plan.window_on_disk = fitting < least;
  plan.window_slices = plan.window_on_disk ? best : std::min(fitting, best);
  const std::uint64_t slices_bytes = static_cast<std::uint64_t>(plan.window_slices) * sliceBytes(info);
  plan.scratch_bytes = plan.window_on_disk ? slices_bytes : 0;
  plan.window_bytes = source.decodeBytes() + (plan.window_on_disk ? stripBytes(info) : slices_bytes);
}

// Upper bound for the parents touched by a brick's part and apron: one neighbour along a halved axis, two along a whole
// axis.
std::uint64_t parentsReached(const Extent3& dims, const Extent3& by, std::int64_t brick_size) {
  std::uint64_t out = 1;
  const Extent3 coarse = coarseBox(boxOf(dims), by).extent();
  for (int axis = 0; axis < 3; ++axis) {
    if (coarse[axis] > brick_size) out *= by[axis] == 2 ? 2 : 3;
  }
  return out;
}

// Size of the pieces that a brick leaves to the parents; pieces overlap by an apron, and are clipped to a thin volume.
// unit: bytes.
std::uint64_t leftBytes(const Extent3& dims, const Extent3& by, std::int64_t brick_size, std::uint64_t voxel_bytes) {
  const Extent3 coarse = coarseBox(boxOf(dims), by).extent();
  const auto along = [&](int axis) { return std::min(brick_size / by[axis], coarse[axis]); };
  std::int64_t voxels = 1;
  // Along a halved axis a part touches one neighbouring parent, along a whole axis two.
  for (int axis = 0; axis < 3; ++axis)
    voxels *= std::min(brick_size / by[axis] + (by[axis] == 2 ? 1 : 2) * kApron, coarse[axis]);
  const Extent3 part = {along(0), along(1), along(2)};
  const std::uint64_t overlap_bytes = static_cast<std::uint64_t>(voxels - part.count()) * voxel_bytes;
  const std::uint64_t neighbours = parentsReached(dims, by, brick_size) - 1;
  return HalfBrick::bytesOf(part, voxel_bytes) + overlap_bytes + overlap_bytes / 4 +
         neighbours * HalfBrick::bytesOf({1, 1, 1}, voxel_bytes);
}

// Upper bound for the bricks of a level that wait at once: a finished brick waits for unfinished ones that are at most
// kReach bricks away, the bricks of its parents' cores and aprons.
// In one block, bricks arrive layer by layer. A parent needs one or two layers for its core, and a layer on either side
// for its apron. The layer below is nearly consumed when the layer above arrives. A volume of a single layer arrives
// row by row, a single row brick by brick; each thread may be ahead by two.
std::uint64_t waitingBricks(const Extent3& dims, const Extent3& by, const BrickOrder& order) {
  const Extent3 lattice = brickLattice(dims, order.lattice().brick_size);
  const int sweep = order.sweep(), across = order.across(0), other = order.across(1);
  if (!order.isOneBlock()) {
    constexpr std::int64_t kReach = 3;
    const std::int64_t width = std::min(order.blockEdge(0), lattice[across]),
                       height = std::min(order.blockEdge(1), lattice[other]);
    // Along the borders of blocks that are finished, and at the front of the block in the making.
    const std::int64_t borders = kReach * lattice[sweep] * (lattice[across] + height + 2 * kReach);
    return static_cast<std::uint64_t>(std::min(borders + (kReach + 1) * width * height, lattice.count()));
  }
  const auto ahead = static_cast<std::int64_t>(lattice[sweep] > 1 ? 0 : 2 * ThreadLimit::active());
  const int front = lattice[sweep] > 1 ? sweep : lattice[other] > 1 ? other : across;
  const std::int64_t layers = std::min(by[front] + 1, lattice[front]);
  return static_cast<std::uint64_t>(std::min(lattice.count() / lattice[front] * layers + ahead, lattice.count()));
}

struct Waiting {
  std::uint64_t part_bytes = 0;   // of all waiting parts
  std::uint64_t place_bytes = 0;  // of the table of parts
};

BrickOrder::Lattice readingLattice(const SourceInfo& info, const ConvertOptions& options) {
  return {info.geometry.dims, options.brick_size, kApron};
}

Waiting waitingOf(const SourceInfo& info, const ConvertOptions& options, const BrickOrder& order) {
  Waiting out;
  const std::vector<VolumeGeometry> levels = pyramidOf(info.geometry, options.brick_size, options.most_levels);
  for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
    const Extent3 dims = levels[l].dims, by = halvingOf(levels[l]);
    const std::uint64_t bricks = waitingBricks(dims, by, order);
    out.part_bytes += bricks * leftBytes(dims, by, options.brick_size, sizeOf(info.type));
    out.place_bytes += bricks * HalfBrickStore::placesBytes(parentsReached(dims, by, options.brick_size));
  }
  return out;
}

// Memory of the tables of bricks, if bricks are converted in this order. unit: bytes.
std::uint64_t tablesOf(const SourceInfo& info, const ConvertOptions& options, const BrickOrder& order) {
  return kBrickBytes * brickCountOf(info, options) + waitingOf(info, options, order).place_bytes;
}

// Returns the fewest blocks that must be kept to decode each of them once.
std::uint64_t leastKeptForOnce(const BrickOrder::Lattice& lattice, const Extent3& shape) {
  std::uint64_t out = UINT64_MAX;
  for (int sweep = 0; sweep < 3; ++sweep)
    out = std::min(out, decodingCost(BrickOrder(lattice, sweep, {1, 1}), shape).blocks_kept);
  return out;
}

// Chooses the order of bricks, and the memory for decoded blocks. Several processes share layers, whose order they all
// know.
void planDecoding(ConversionPlan& plan, const VolumeSource& source, const ConvertOptions& options) {
  const SourceInfo& info = source.info();
  const BrickOrder::Lattice lattice = readingLattice(info, options);
  const std::optional<DecodedBlocks> blocks = source.decodedBlocks();
  const std::uint64_t left = options.memory_bytes - plan.total();
  if (!blocks) {
    // Decoded parts of unknown shape: the slices of two layers.
    const std::int64_t slices = std::min(2 * (options.brick_size + kApron), info.geometry.dims.z);
    if (source.decodeBytes() > 0)
      plan.kept_bytes = std::min(left, static_cast<std::uint64_t>(slices) * sliceBytes(info));
    return;
  }
  const std::uint64_t block_bytes = blocks->bytes + BlockCache::kOwnBytes;
  if (options.ranks == nullptr || options.ranks->alone()) {
    const std::uint64_t for_tables = left / 16;
    const auto tablesBeyond = [&](const BrickOrder& order) {
      return std::max(tablesOf(info, options, order), plan.index_bytes) - plan.index_bytes;
    };
    BrickOrder order = cheapestOrder(lattice, blocks->shape, left / block_bytes);
    // The tables of this order may take the room of its last blocks.
    if (decodingCost(order, blocks->shape).blocks_kept * block_bytes + tablesBeyond(order) > left)
      order = cheapestOrder(lattice, blocks->shape, (left - for_tables) / block_bytes);
    if (tablesBeyond(order) <= for_tables) {
      plan.index_bytes += tablesBeyond(order);
      plan.order = order;
    }
  }
  const std::uint64_t room = options.memory_bytes - plan.total();
  const DecodingCost cost = decodingCost(*plan.order, blocks->shape);
  plan.kept_bytes = std::min(room, cost.blocks_kept * block_bytes);
  plan.decodings = cost.blocks_kept * block_bytes <= room ? cost.decodings : decodingsUnkept(lattice, blocks->shape);
  plan.once_bytes = plan.source_bytes + usefulLanes(source) * (plan.lane_bytes + fileBytes(info, options)) +
                    plan.index_bytes + allSubRangesBytes(info, options) +
                    leastKeptForOnce(lattice, blocks->shape) * block_bytes;
}

// throws: Error kBudget. If tables dominate, the error also proposes larger bricks.
void requireMemoryFor(const ConversionPlan& plan, const SourceInfo& info, const ConvertOptions& options) {
  const std::uint64_t others = plan.source_bytes + plan.window_bytes + plan.lane_bytes;
  const std::uint64_t smallest = others + plan.index_bytes;
  if (smallest <= options.memory_bytes) return;
  const fs::path file = info.files.empty() ? fs::path() : info.files.front();
  if (plan.index_bytes > others) {
    throw Error(ErrorCode::kBudget, file, "--memory",
                fmt::format("the tables of {} bricks take {}, beside {} to read and convert with (allowed: {}); give "
                            "--memory {}, or a --brick-size larger than {}",
                            brickCountOf(info, options), formatBytes(plan.index_bytes), formatBytes(others),
                            formatBytes(options.memory_bytes), roundedUpBytes(smallest), options.brick_size));
  }
  throw Error(ErrorCode::kBudget, file, "--memory",
              fmt::format("{} is too little: {} is the smallest that works here ({} to read, {} a thread, {} for the "
                          "tables of bricks)",
                          formatBytes(options.memory_bytes), roundedUpBytes(smallest),
                          formatBytes(plan.source_bytes + plan.window_bytes), formatBytes(plan.lane_bytes),
                          formatBytes(plan.index_bytes)));
}

}  // namespace

ConversionPlan planConversion(const VolumeSource& source, const ConvertOptions& options) {
  const SourceInfo& info = source.info();
  const bool forward = source.order() == ReadOrder::kForward;
  ConversionPlan plan;
  plan.source_bytes = source.heldBytes();
  plan.lane_bytes = laneBytes(info, options) + (forward ? 0 : source.decodeBytes());
  plan.index_bytes = tablesBytes(info, options);
  if (forward) planWindow(plan, source, options);
  requireMemoryFor(plan, info, options);
  const std::uint64_t fitting =
      (options.memory_bytes - plan.source_bytes - plan.window_bytes - plan.index_bytes) / plan.lane_bytes;
  plan.lanes = static_cast<std::size_t>(std::min(fitting, usefulLanes(source)));
  plan.given_bytes = plan.lanes * givenBytes(info, options);
  const std::uint64_t unwritten_bytes = plan.lanes * fileBytes(info, options);
  if (plan.lanes > 1 && plan.total() + unwritten_bytes <= options.memory_bytes) {
    plan.unwritten_bricks = plan.lanes;
    plan.unwritten_bytes = unwritten_bytes;
  }
  const std::uint64_t sub_ranges_bytes = allSubRangesBytes(info, options);
  plan.sub_ranges_on_disk = plan.total() + sub_ranges_bytes > options.memory_bytes;
  if (plan.sub_ranges_on_disk)
    plan.scratch_bytes += brickCountOf(info, options) * SubRanges::bytesOf(subBricksOf(options.brick_size));
  else
    plan.sub_ranges_bytes = sub_ranges_bytes;
  plan.order.emplace(readingLattice(info, options));
  if (!forward) planDecoding(plan, source, options);
  const std::uint64_t waiting = waitingOf(info, options, *plan.order).part_bytes;
  plan.parts_bytes = std::min(options.memory_bytes - plan.total(), waiting);
  plan.scratch_bytes += waiting - plan.parts_bytes;
  return plan;
}

std::uint64_t brickCountOf(const SourceInfo& info, const ConvertOptions& options) {
  std::uint64_t out = 0;
  for (const VolumeGeometry& level : pyramidOf(info.geometry, options.brick_size, options.most_levels))
    out += static_cast<std::uint64_t>(brickLattice(level.dims, options.brick_size).count());
  return out;
}

std::uint64_t tablesBytes(const SourceInfo& info, const ConvertOptions& options) {
  return tablesOf(info, options, BrickOrder(readingLattice(info, options)));
}

void requireRoomForIndex(const SourceInfo& info, const ConvertOptions& options) {
  const Extent3& dims = info.geometry.dims;
  const Extent3 lattice = brickLattice(dims, options.brick_size);
  const double bytes =
      static_cast<double>(lattice.x) * static_cast<double>(lattice.y) * static_cast<double>(lattice.z) * kBrickBytes;
  const double most = static_cast<double>(machineMemoryBytes()) / 2;
  if (bytes <= most) return;
  throw Error(
      ErrorCode::kBudget, info.files.empty() ? std::filesystem::path() : info.files.front(), "--brick-size",
      fmt::format("{} x {} x {} voxels are {} x {} x {} bricks of {}, whose index alone takes {:.0f} GiB of this "
                  "machine's {}; convert only the part that holds something",
                  dims.x, dims.y, dims.z, lattice.x, lattice.y, lattice.z, options.brick_size, bytes / (1u << 30),
                  formatBytes(machineMemoryBytes())));
}

}  // namespace kiln
