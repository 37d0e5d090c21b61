// Exports the bricks of a level as grids, brick by brick. The kind of filler decides what a voxel becomes.
#include "export/vdb/export_vdb.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <type_traits>

#include "base/file/chosen_disk.h"
#include "base/file/file.h"
#include "base/file/path_status.h"
#include "base/memory/memory.h"
#include "base/refusal.h"
#include "export/vdb/baked_filler.h"
#include "export/vdb/grid_filler.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"
#include "store/codec/brick_codec.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

std::int64_t leavesDown(std::int64_t a) { return a >> kLeafLog2; }

// Returns a box of the voxels of all leaves that `part` touches in the grid.
VoxelBox touchedLeaves(const GridPlacement& place, const VoxelBox& part) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = part.lo[axis] + place.origin[axis], hi = part.hi[axis] + place.origin[axis];
    out.lo[axis] = leavesDown(lo) << kLeafLog2;
    out.hi[axis] = (leavesDown(hi - 1) + 1) << kLeafLog2;
  }
  return out;
}

// Returns a box of as many voxels as the leaves have that `part` fills in part; all others become tiles of one value.
VoxelBox partLeaves(const GridPlacement& place, const VoxelBox& part) {
  std::int64_t touched = 1, whole = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = part.lo[axis] + place.origin[axis], hi = part.hi[axis] + place.origin[axis];
    touched *= leavesDown(hi - 1) + 1 - leavesDown(lo);
    whole *= std::max<std::int64_t>(leavesDown(hi) - leavesDown(lo + kLeafEdge - 1), 0);
  }
  return boxOf({(touched - whole) * kLeafEdge, kLeafEdge, kLeafEdge});
}

// Memory for any content of the volume: all voxels of all stored bricks in the tree, one brick being read, the index.
template <class Filler>
std::uint64_t sufficientBytes(const StoreReader& store, const ExportedVolume& volume, const GridPlacement& place) {
  const Extent3 lattice = store.level(volume.level).bricks;
  std::uint64_t grid = 0, read = 0;
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    const BrickKey key{volume.level, brickAt(lattice, i)};
    const VoxelBox part = intersection(store.frame(key).core(), volume.box);
    if (part.empty()) continue;
    const bool constant = store.index().at(key).constant;
    grid += Filler::growthBytes(constant ? partLeaves(place, part) : touchedLeaves(place, part));
    if (constant) continue;
    read = std::max<std::uint64_t>(read, store.readBytes(key));
  }
  return grid + read + store.index().bytes();
}

/// The parts of an export that every kind of grid needs.
struct GridExport {
  const StoreReader& store;
  const ExportedVolume& volume;
  const VdbRequest& request;
  const GridPlacement& place;
  /// For the grids and a brick. unit: bytes.
  std::uint64_t memory_bytes;
  Progress& progress;
};

struct FilledGrids {
  openvdb::GridPtrVec grids;
  double largest_error = 0;
};

template <class Filler>
FilledGrids filledBy(Filler filler, const GridExport& parts) {
  const auto& [store, volume, request, place, memory_bytes, progress] = parts;
  const Extent3 lattice = store.level(volume.level).bricks;
  const auto refuse = [&](const BrickKey& key) {
    throw Error(ErrorCode::kBudget, parts.request.out, "--memory",
                fmt::format("{} beside the index is too little: the grid and reading one brick take more (found a "
                            "brick of {}); give --memory {}, which surely suffices, or export a coarser level",
                            formatBytes(parts.memory_bytes), formatBytes(parts.store.readBytes(key)),
                            roundedUpBytes(sufficientBytes<Filler>(parts.store, parts.volume, parts.place))));
  };
  const auto bricks = static_cast<std::uint64_t>(lattice.count());
  for (std::uint64_t i = 0; i < bricks; ++i) {
    progress.throwIfCancelled("exporting");
    const BrickKey key{volume.level, brickAt(lattice, static_cast<std::int64_t>(i))};
    const BrickEntry& entry = store.index().at(key);
    const VoxelBox part = intersection(store.frame(key).core(), volume.box);
    if (part.empty()) continue;
    if (entry.constant) {
      if (filler.holds(entry.core.lo) && !filler.charge(partLeaves(place, part), 0)) refuse(key);
      filler.fill(part, entry.core.lo);
    } else {
      if (!filler.charge(touchedLeaves(place, part), store.readBytes(key))) refuse(key);
      filler.take(store.read(key), part);
    }
    progress.advance("exporting", "bricks", i + 1, bricks);
  }
  return {filler.finish(), filler.largestError()};
}

// Writes the bytes of openvdb::io::File, which ignores failed writes: a full disk would go unnoticed.
class CheckedArchive : public openvdb::io::Archive {
 public:
  void write(const openvdb::GridPtrVec& grids, const fs::path& path) {
    setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    std::ofstream file;
    file.exceptions(std::ios::badbit | std::ios::failbit);
    file.open(path, std::ios::binary | std::ios::trunc);
    Archive::write(file, openvdb::GridCPtrVec(grids.begin(), grids.end()), /*seekable=*/true);
    file.close();
  }
};

// Checks that Blosc can allocate its working memory for a block of `bytes`: Blosc does not check, and its failed
// allocation would end the process. The allocator gives the freed memory to the next call of this thread.
void requireBloscMemory(std::size_t bytes) { requireMemory(3 * bytes + 4096); }

void publish(const openvdb::GridPtrVec& grids, const fs::path& out, FileSystem& disk) {
  disk.replace(out, [&](const fs::path& temporary) {
    try {
      constexpr std::size_t kLargestLeaf = 512 * sizeof(double);
      requireBloscMemory(kLargestLeaf);
      errno = 0;
      CheckedArchive().write(grids, temporary);
    } catch (const std::exception& error) {
      const int error_number = errno;
      rethrowRefusal();
      // OpenVDB reports only that writing failed; errno has the cause.
      if (error_number != 0) throw systemError(error_number, out, "writing the grid");
      throw Error(ErrorCode::kIo, out, "OpenVDB", error.what());
    }
    disk.syncFile(temporary);
  });
}

// Checks that a grid of this type holds every value of the store, and the background.
template <class Grid>
void requireValuesFit(const Manifest& manifest, const VdbRequest& request) {
  using Value = typename Grid::ValueType;
  constexpr double kLargestHalf = 65504;
  const VdbValues& values = request.values;
  const double most =
      values.type == VdbType::kHalf ? kLargestHalf : static_cast<double>(std::numeric_limits<Value>::max());
  const double largest = std::max(std::abs(manifest.range.lo), std::abs(manifest.range.hi));
  if (values.type != VdbType::kExact && !manifest.range.empty() && largest > most)
    throw Error(ErrorCode::kUsage, request.out, "--type",
                fmt::format("values must be at most {:g} (found {:g}); {}", most, largest,
                            values.type == VdbType::kHalf ? "write --type float" : "leave --type out"));
  if (!values.background) return;
  const bool whole = std::is_floating_point_v<Value> || *values.background == std::floor(*values.background);
  if (!whole || !(std::abs(*values.background) <= most))
    throw Error(ErrorCode::kUsage, request.out, "--background",
                fmt::format("must be a value of the grid (found {:g})", *values.background));
}

FilledGrids filledGrids(const GridExport& parts) {
  const Manifest& manifest = parts.store.manifest();
  const VdbRequest& request = parts.request;
  return withVoxelType(manifest.type, [&]<class T>(std::type_identity<T>) {
    if (request.baked)
      return filledBy(BakedFiller<T>(*request.baked, request.values.type, parts.place, parts.memory_bytes), parts);
    const auto filled = [&]<class Grid>(std::type_identity<Grid>) {
      requireValuesFit<Grid>(manifest, request);
      return filledBy(GridFiller<T, Grid>(manifest, request.values, parts.place, parts.memory_bytes), parts);
    };
    // Labels are whole numbers, exported in the integer type that Kiln can read back.
    if (manifest.volume_class == VolumeClass::kLabels) return filled(std::type_identity<openvdb::Int32Grid>());
    if (request.values.type != VdbType::kExact) return filled(std::type_identity<openvdb::FloatGrid>());
    return filled(std::type_identity<GridFor<T>>());
  });
}

void requireLabelsKept(const StoreReader& store, const VdbRequest& request) {
  if (request.baked || store.manifest().volume_class != VolumeClass::kLabels) return;
  if (store.manifest().range.hi > 2147483647.0)
    throw Error(ErrorCode::kUnsupported, request.out, "",
                "labels beyond 2147483647 have no OpenVDB grid that others read");
  if (request.values.type != VdbType::kExact || request.values.tolerance != 0)
    throw Error(ErrorCode::kUsage, request.out, request.values.tolerance != 0 ? "--tolerance" : "--type",
                "is for measured values, and this store holds labels; leave it out");
}

void requireBakeable(const VdbRequest& request) {
  if (!request.baked) return;
  if (!request.baked->gradient_opacity.empty())
    throw Error(ErrorCode::kUsage, request.out, "--tf",
                "must not depend on gradients, which grids do not hold; remove gradientOpacity from the function");
  if (request.values.background || request.values.tolerance != 0)
    throw Error(ErrorCode::kUsage, request.out, "--tf",
                "has its own empty space; leave --background and --tolerance out");
}

}  // namespace

VdbReport exportVdb(const StoreReader& store, const ExportedVolume& volume, const VdbRequest& request,
                    Progress& progress, FileSystem& disk) {
  if (!request.overwrite && isThere(request.out)) {
    throw Error(ErrorCode::kExists, request.out, "", "is there already; name another output or give --overwrite");
  }
  requireLabelsKept(store, request);
  requireBakeable(request);
  disk.requirePlaceToRename(request.out);
  initializeOpenVdb();
  const GridPlacement place = placementOf(store, volume.level, request.out);
  const std::uint64_t memory_bytes = request.memory_bytes - std::min(request.memory_bytes, store.index().bytes());
  const FilledGrids filled = filledGrids({store, volume, request, place, memory_bytes, progress});
  VdbReport report;
  report.voxels = filled.grids.front()->activeVoxelCount();
  report.largest_error = filled.largest_error;
  publish(filled.grids, request.out, disk);
  report.bytes = File(request.out).size();
  return report;
}

}  // namespace kiln
