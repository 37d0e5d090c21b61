// Exports the bricks of a level as grids, brick by brick. The kind of filler decides what a voxel becomes.
#include "export/vdb/export_vdb.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <type_traits>

#include "base/file/chosen_disk.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/refusal.h"
#include "export/source/output_place.h"
#include "export/source/store_boxes.h"
#include "export/vdb/baked_filler.h"
#include "export/vdb/grid_archive.h"
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

/// The parts of an export that every kind of grid needs.
struct GridExport {
  const StoreReader& store;
  const ExportedVolume& volume;
  const VdbRequest& request;
  const GridPlacement& place;
  /// For the grids, in the file's form, too, and a brick. unit: bytes.
  std::uint64_t memory_bytes;
  Progress& progress;

  std::uint64_t copies() const { return request.archive.copies(); }
};

struct FilledGrids {
  openvdb::GridPtrVec grids;
  double largest_error = 0;
};

// The leaves of a brick's part, larger by `reach` on each side, that hold voxels of their own, as a box of as many
// voxels.
VoxelBox heldLeaves(const GridExport& parts, const BricksOfBox::Part& brick, std::int64_t reach) {
  const bool constant = parts.store.index().at(brick.key).constant;
  VoxelBox box = brick.box;
  for (int axis = 0; axis < 3; ++axis) box.lo[axis] -= reach, box.hi[axis] += reach;
  return constant ? partLeaves(parts.place, box) : touchedLeaves(parts.place, box);
}

// Memory for reading a brick; none for a constant brick. unit: bytes.
std::uint64_t readingBytes(const StoreReader& store, const BrickKey& key) {
  return store.index().at(key).constant ? 0 : store.readBytes(key);
}

// Charges the tree of a grid: before a brick is read, the tree, its growth and the reading of the brick must fit.
template <class Filler>
class TreeCharge {
 public:
  TreeCharge(const GridExport& parts, const Filler& filler) : parts_(parts), filler_(filler) {}

  /// Charges a brick whose voxels may all enter the tree. The tree is measured only if its upper bound is too large.
  /// throws: Error kBudget.
  void add(const BricksOfBox::Part& brick) {
    const std::uint64_t growth = growthBytes(brick), needed = growth + readingBytes(parts_.store, brick.key);
    if (held_bytes_ + needed > parts_.memory_bytes)
      held_bytes_ = Filler::kFixedBytes + parts_.copies() * filler_.treeBytes();
    if (held_bytes_ + needed > parts_.memory_bytes) refuse(brick.key);
    held_bytes_ += growth;
  }
  /// Charges what the end of the filling adds. throws: Error kBudget.
  void addFinish(std::uint64_t bytes, const BrickKey& any) {
    if (bytes == 0) return;
    held_bytes_ = Filler::kFixedBytes + parts_.copies() * (filler_.treeBytes() + bytes);
    if (held_bytes_ > parts_.memory_bytes) refuse(any);
  }

 private:
  std::uint64_t growthBytes(const BricksOfBox::Part& brick) const {
    return parts_.copies() * static_cast<std::uint64_t>(heldLeaves(parts_, brick, Filler::kReach).count()) *
           Filler::kVoxelBytes;
  }
  // Memory for any content of the volume: all voxels of all bricks in the tree, one brick being read, the index.
  std::uint64_t sufficientBytes() const {
    const BricksOfBox bricks(parts_.store, parts_.volume.level, parts_.volume.box);
    std::uint64_t grid = Filler::kFixedBytes, read = 0;
    for (std::size_t i = 0; i < bricks.count(); ++i) {
      grid += growthBytes(bricks.at(i));
      read = std::max(read, readingBytes(parts_.store, bricks.at(i).key));
    }
    return grid + read + parts_.store.index().bytes();
  }
  [[noreturn]] void refuse(const BrickKey& key) const {
    throw Error(ErrorCode::kBudget, parts_.request.out, "--memory",
                fmt::format("{} beside the index is too little: the grid and reading one brick take more (found a "
                            "brick of {}); give --memory {}, which surely suffices, or export a coarser level",
                            formatBytes(parts_.memory_bytes), formatBytes(parts_.store.readBytes(key)),
                            roundedUpBytes(sufficientBytes())));
  }

  const GridExport& parts_;
  const Filler& filler_;
  std::uint64_t held_bytes_ = Filler::kFixedBytes;
};

// Refuses values that a grid of floats cannot hold, in the words of the largest value that it can.
[[noreturn]] void refuseBeyond(const VdbRequest& request, double most, const std::string& found) {
  if (request.baked && request.values.type != VdbType::kHalf)
    throw Error(ErrorCode::kUsage, request.out, "--tf",
                fmt::format("densities must be at most {:g} (found {}); choose a function with a larger unit of length",
                            most, found));
  throw Error(ErrorCode::kUsage, request.out, "--type",
              fmt::format("{} must be at most {:g} (found {}); {}", request.baked ? "densities" : "values", most, found,
                          request.values.type == VdbType::kHalf ? "write --type float" : "leave --type out"));
}

double largestOf(VdbType type, double of_grid) {
  constexpr double kLargestOfHalf = 65504;
  return type == VdbType::kHalf ? kLargestOfHalf : of_grid;
}

template <class Filler>
FilledGrids filledBy(Filler filler, const GridExport& parts) {
  const auto& [store, volume, request, place, memory_bytes, progress] = parts;
  const BricksOfBox bricks(store, volume.level, volume.box);
  TreeCharge<Filler> charge(parts, filler);
  for (std::size_t i = 0; i < bricks.count(); ++i) {
    progress.throwIfCancelled("exporting");
    const BricksOfBox::Part brick = bricks.at(i);
    if (const std::optional<double> constant = store.constantOf(brick.key)) {
      if (filler.holds(*constant)) charge.add(brick);
      filler.fill(brick.box, *constant);
    } else {
      charge.add(brick);
      filler.take(store.read(brick.key), brick.box);
    }
    if (std::isinf(filler.largestError()))
      refuseBeyond(request, largestOf(request.values.type, std::numeric_limits<float>::max()), "a larger value");
    progress.advance("exporting", "bricks", i + 1, bricks.count());
  }
  if (bricks.count() > 0) charge.addFinish(filler.finishBytes(), bricks.at(0).key);
  return {filler.finish(), filler.largestError()};
}

// Checks that Blosc can allocate its working memory for a block of `bytes`: Blosc does not check, and its failed
// allocation would end the process. The allocator gives the freed memory to the next call of this thread.
void requireBloscMemory(std::size_t bytes) { requireMemory(3 * bytes + 4096); }

// Writes the bytes of openvdb::io::File.
class OpenVdbArchive final : public GridArchive {
 public:
  void write(const openvdb::GridPtrVec& grids, std::ostream& file) const override {
    constexpr std::size_t kLargestLeaf = 512 * sizeof(double);
    requireBloscMemory(kLargestLeaf);
    Writer().write(grids, file);
  }
  const char* name() const override { return "OpenVDB"; }
  std::uint64_t copies() const override { return 1; }

 private:
  struct Writer : openvdb::io::Archive {
    void write(const openvdb::GridPtrVec& grids, std::ostream& file) {
      setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
      Archive::write(file, openvdb::GridCPtrVec(grids.begin(), grids.end()), /*seekable=*/true);
    }
  };
};

// The libraries' own files ignore failed writes: a full disk would go unnoticed.
void writeChecked(const openvdb::GridPtrVec& grids, const GridArchive& archive, const fs::path& path) {
  std::ofstream file;
  file.exceptions(std::ios::badbit | std::ios::failbit);
  file.open(path, std::ios::binary | std::ios::trunc);
  archive.write(grids, file);
  file.close();
}

void publish(const openvdb::GridPtrVec& grids, const GridArchive& archive, const fs::path& out, FileSystem& disk) {
  disk.replace(out, [&](const fs::path& temporary) {
    try {
      errno = 0;
      writeChecked(grids, archive, temporary);
    } catch (const std::exception& error) {
      const int error_number = errno;
      rethrowRefusal();
      // The libraries report only that writing failed; errno has the cause.
      if (error_number != 0) throw systemError(error_number, out, "writing the grid");
      throw Error(ErrorCode::kIo, out, "OpenVDB", error.what());
    }
    disk.syncFile(temporary);
  });
}

// Checks that a grid of this type holds the background, and every value of the store; infinities stay. The range of a
// store with infinities does not bound its other values, which are checked one by one.
template <class Grid>
void requireValuesFit(const Manifest& manifest, const VdbRequest& request) {
  using Value = typename Grid::ValueType;
  const VdbValues& values = request.values;
  const double most = largestOf(values.type, static_cast<double>(std::numeric_limits<Value>::max()));
  const double largest = std::max(std::abs(manifest.range.lo), std::abs(manifest.range.hi));
  if (values.type != VdbType::kExact && std::isfinite(largest) && largest > most)
    refuseBeyond(request, most, fmt::format("{:g}", largest));
  if (!values.background) return;
  const bool whole = std::is_floating_point_v<Value> || *values.background == std::floor(*values.background);
  // The largest number of 64 bits is no double, and `most` is the next larger double.
  const bool rounded_up = std::is_same_v<Value, std::int64_t>;
  const double size = std::abs(*values.background);
  if (!whole || !(rounded_up ? size < most : size <= most))
    throw Error(ErrorCode::kUsage, request.out, "--background",
                fmt::format("must be a value of the grid (found {:g})", *values.background));
}

FilledGrids filledGrids(const GridExport& parts) {
  const Manifest& manifest = parts.store.manifest();
  const VdbRequest& request = parts.request;
  return withVoxelType(manifest.type, [&]<class T>(std::type_identity<T>) {
    if (request.baked) return filledBy(BakedFiller<T>(*request.baked, request.values.type, parts.place), parts);
    const auto filled = [&]<class Grid>(std::type_identity<Grid>) {
      requireValuesFit<Grid>(manifest, request);
      return filledBy(GridFiller<T, Grid>(manifest, request.values, parts.place), parts);
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
  if (!request.baked->surfaces.empty())
    throw Error(ErrorCode::kUsage, request.out, "--tf",
                "must not be surfaces, which grids of opacities do not hold; choose solid:VALUE");
  if (request.baked->usesGradient())
    throw Error(ErrorCode::kUsage, request.out, "--tf",
                "must not depend on gradients, which grids do not hold; remove gradientOpacity, regions and table from "
                "the function");
  if (request.values.background || request.values.tolerance != 0)
    throw Error(ErrorCode::kUsage, request.out, "--tf",
                "has its own empty space; leave --background and --tolerance out");
}

}  // namespace

const GridArchive& openVdbArchive() {
  static const OpenVdbArchive archive;
  return archive;
}

VdbReport exportVdb(const StoreReader& store, const ExportedVolume& volume, const VdbRequest& request,
                    Progress& progress, FileSystem& disk) {
  requirePlace(store, request.out, request.overwrite, disk);
  requireLabelsKept(store, request);
  requireBakeable(request);
  initializeOpenVdb();
  const GridPlacement place = placementOf(store, volume.level, request.out);
  const std::uint64_t memory_bytes = request.memory_bytes - std::min(request.memory_bytes, store.index().bytes());
  const FilledGrids filled = filledGrids({store, volume, request, place, memory_bytes, progress});
  VdbReport report;
  report.voxels = filled.grids.front()->activeVoxelCount();
  report.largest_error = filled.largest_error;
  publish(filled.grids, request.archive, request.out, disk);
  report.bytes = File(request.out).size();
  return report;
}

}  // namespace kiln
