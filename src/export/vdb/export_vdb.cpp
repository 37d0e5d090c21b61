// Exports the bricks of a level as a single grid. A leaf overlaps up to eight bricks unless the grid's coordinates are
// offset by multiples of 8. So voxels are set individually through an accessor; a constant brick is a fill.
// Invariant: unset voxels have the grid's background value, so bricks of background are free.
#include "export/vdb/export_vdb.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <type_traits>

#include "base/memory/memory.h"
#include "base/path_status.h"
#include "base/refusal.h"
#include "grid/openvdb_glue.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

template <class Value>
bool sameBits(Value a, Value b) {
  return std::memcmp(&a, &b, sizeof(Value)) == 0;
}

// Maps the voxels of a level to grid coordinates.
struct GridPlacement {
  std::string name = "density";
  VoxelCoord origin;
  glm::dmat4 world_from_grid{1.0};

  openvdb::Coord of(const VoxelCoord& v) const { return coordOf({v.x + origin.x, v.y + origin.y, v.z + origin.z}); }
};

GridPlacement placementOf(const StoreReader& store, int level, const fs::path& out) {
  GridPlacement place;
  const VolumeGeometry& geometry = store.level(level).geometry;
  if (store.manifest().volume_class == VolumeClass::kLabels) place.name = "labels";
  place.world_from_grid = geometry.world_from_index;
  if (const auto& vdb = store.manifest().source.vdb) {
    place.name = vdb->grid_name;
    if (level == 0) {
      place.origin = vdb->index_origin;
      place.world_from_grid = vdb->world_from_grid;
    }
  }
  if (!hasTransform(place.world_from_grid)) {
    const glm::dvec3 edge = geometry.spacing(), origin = geometry.worldOf({0, 0, 0});
    throw Error(ErrorCode::kUnsupported, out, "geometry",
                fmt::format("OpenVDB has no transform for voxels of {:g} x {:g} x {:g} world units from ({:g}, {:g}, "
                            "{:g}) on; convert the source again with its lengths in a smaller unit",
                            edge.x, edge.y, edge.z, origin.x, origin.y, origin.z));
  }
  for (int axis = 0; axis < 3; ++axis) {
    constexpr std::int64_t kLo = std::numeric_limits<std::int32_t>::min(),
                           kHi = std::numeric_limits<std::int32_t>::max();
    if (place.origin[axis] < kLo || place.origin[axis] + geometry.dims[axis] - 1 > kHi) {
      throw Error(ErrorCode::kUnsupported, out, "", "the volume goes beyond OpenVDB's 32-bit coordinates");
    }
  }
  return place;
}

template <class T, class Grid>
class GridFiller {
 public:
  using Value = typename Grid::ValueType;

  GridFiller(const Manifest& manifest, const VdbValues& values, const GridPlacement& place, std::uint64_t memory_bytes)
      : memory_bytes_(memory_bytes),
        values_(values),
        level_set_(manifest.volume_class == VolumeClass::kLevelSet),
        background_(gridBackground(manifest, values)),
        place_(place),
        grid_(newGrid<Grid>(background_)) {
    grid_->setName(place.name);
    grid_->setTransform(transformOf(place.world_from_grid));
    if (manifest.volume_class == VolumeClass::kFog) grid_->setGridClass(openvdb::GRID_FOG_VOLUME);
    if (level_set_) grid_->setGridClass(openvdb::GRID_LEVEL_SET);
  }

  void fill(const VoxelBox& box, double constant) {
    const Value value = written(static_cast<T>(constant));
    note(value);
    if (isBackground(value)) return;
    grid_->sparseFill({place_.of(box.lo), place_.of({box.hi.x - 1, box.hi.y - 1, box.hi.z - 1})}, value, active(value));
  }

  // Takes the voxels of `part` of a block.
  void take(const BrickBlock& block, const VoxelBox& part) {
    const T* const voxels = block.data<T>();
    auto accessor = grid_->getAccessor();
    for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
        const T* const row = voxels + block.offsetOf({part.lo.x, y, z});
        for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
          const Value value = written(row[x - part.lo.x]);
          if (isBackground(value)) continue;
          note(value);
          if (active(value)) {
            accessor.setValueOn(place_.of({x, y, z}), value);
          } else {
            accessor.setValueOff(place_.of({x, y, z}), value);
          }
        }
      }
    }
  }

  // Charges a part of a brick of which all voxels enter the tree. Called before the brick is read: the tree before, its
  // growth and the reading of the brick must fit. The tree is measured only if its upper bound is too large. Returns
  // false if the brick does not fit.
  bool charge(const VoxelBox& part, std::uint64_t read_bytes) {
    const std::uint64_t needed = growthBytes(part) + read_bytes;
    if (held_bytes_ + needed > memory_bytes_) held_bytes_ = grid_->memUsage();
    if (held_bytes_ + needed > memory_bytes_) return false;
    held_bytes_ += growthBytes(part);
    return true;
  }

  /// Upper bound of the leaves of a part of a brick. unit: bytes.
  static std::uint64_t growthBytes(const VoxelBox& part) {
    return static_cast<std::uint64_t>(part.count()) * (sizeof(Value) + 1);
  }

  typename Grid::Ptr finish() {
    // Merges only nodes of one value and state, compared exactly. Skipped for signed zeros, because == would lose -0.
    if (!signed_zero_) grid_->pruneGrid(0);
    if constexpr (std::is_same_v<Value, float>)
      grid_->setSaveFloatAsHalf(values_.type != VdbType::kFloat && half_ && survivesHalf(background_));
    return grid_;
  }
  double largestError() const { return largest_error_; }

 private:
  static Value gridBackground(const Manifest& manifest, const VdbValues& values) {
    return rounded(static_cast<Value>(values.background.value_or(manifest.background)), values.type);
  }
  static Value rounded(Value value, VdbType type) {
    if constexpr (std::is_same_v<Value, float>)
      if (type == VdbType::kHalf) return static_cast<float>(openvdb::math::half(value));
    return value;
  }
  // The value that the grid gets for a voxel. An exact grid changes none.
  Value written(T voxel) {
    if (values_.type == VdbType::kExact && values_.tolerance == 0) return static_cast<Value>(voxel);
    const bool near = std::abs(static_cast<double>(voxel) - static_cast<double>(background_)) <= values_.tolerance;
    const Value value = near && values_.tolerance > 0 ? background_ : rounded(static_cast<Value>(voxel), values_.type);
    const double error = std::abs(static_cast<double>(value) - static_cast<double>(voxel));
    if (error > largest_error_) largest_error_ = error;  // false for NaN
    return value;
  }
  bool isBackground(Value value) const { return sameBits(value, background_); }
  bool active(Value value) const {
    if constexpr (std::is_floating_point_v<Value>) {
      // The negated >= is also true for NaN: a NaN in a level set stays active, so that users see it.
      if (level_set_) return !(std::abs(value) >= background_);
    }
    return !isBackground(value);
  }
  void note(Value value) {
    if constexpr (std::is_floating_point_v<Value>) signed_zero_ |= value == 0 && std::signbit(value);
    if constexpr (std::is_same_v<Value, float>) half_ = half_ && survivesHalf(value);
  }

  std::uint64_t memory_bytes_;
  const VdbValues& values_;
  bool level_set_;
  Value background_;
  const GridPlacement& place_;
  typename Grid::Ptr grid_;
  std::uint64_t held_bytes_ = 0;
  double largest_error_ = 0;
  bool half_ = true, signed_zero_ = false;
};

// Memory for any content of the volume: all voxels of all stored bricks in the tree, one brick being read, the index.
template <class Filler>
std::uint64_t sufficientBytes(const StoreReader& store, const ExportedVolume& volume) {
  const Extent3 lattice = store.level(volume.level).bricks;
  std::uint64_t grid = 0, read = 0;
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    const BrickKey key{volume.level, brickAt(lattice, i)};
    const VoxelBox part = intersection(store.frame(key).core(), volume.box);
    if (part.empty() || store.index().at(key).constant) continue;
    grid += Filler::growthBytes(part);
    read = std::max<std::uint64_t>(read, store.readBytes(key));
  }
  return grid + read + store.index().bytes();
}

struct FilledGrid {
  openvdb::GridBase::Ptr grid;
  double largest_error = 0;
};

template <class T, class Grid>
FilledGrid gridOf(const StoreReader& store, const ExportedVolume& volume, const VdbRequest& request,
                  const GridPlacement& place, std::uint64_t memory_bytes, Progress& progress) {
  GridFiller<T, Grid> filler(store.manifest(), request.values, place, memory_bytes);
  const Extent3 lattice = store.level(volume.level).bricks;
  const auto refuse = [&](const BrickKey& key) {
    throw Error(ErrorCode::kBudget, request.out, "--memory",
                fmt::format("{} beside the index is too little: the grid and reading one brick take more (found a "
                            "brick of {}); give --memory {}, which surely suffices, or export a coarser level",
                            formatBytes(memory_bytes), formatBytes(store.readBytes(key)),
                            roundedUpBytes(sufficientBytes<GridFiller<T, Grid>>(store, volume))));
  };
  const auto bricks = static_cast<std::uint64_t>(lattice.count());
  for (std::uint64_t i = 0; i < bricks; ++i) {
    progress.throwIfCancelled("exporting");
    const BrickKey key{volume.level, brickAt(lattice, static_cast<std::int64_t>(i))};
    const BrickEntry& entry = store.index().at(key);
    const VoxelBox part = intersection(store.frame(key).core(), volume.box);
    if (part.empty()) continue;
    if (entry.constant) {
      filler.fill(part, entry.core.lo);
    } else {
      if (!filler.charge(part, store.readBytes(key))) refuse(key);
      filler.take(store.read(key), part);
    }
    progress.advance("exporting", "bricks", i + 1, bricks);
  }
  return {filler.finish(), filler.largestError()};
}

// Writes the bytes of openvdb::io::File, which ignores failed writes: a full disk would go unnoticed.
class CheckedArchive : public openvdb::io::Archive {
 public:
  void write(const openvdb::GridBase::Ptr& grid, const fs::path& path) {
    setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    std::ofstream file;
    file.exceptions(std::ios::badbit | std::ios::failbit);
    file.open(path, std::ios::binary | std::ios::trunc);
    Archive::write(file, openvdb::GridCPtrVec{grid}, /*seekable=*/true);
    file.close();
  }
};

void publish(const openvdb::GridBase::Ptr& grid, const fs::path& out, FileSystem& disk) {
  disk.replace(out, [&](const fs::path& temporary) {
    try {
      constexpr std::size_t kLargestLeaf = 512 * sizeof(double);
      requireBloscMemory(kLargestLeaf);
      errno = 0;
      CheckedArchive().write(grid, temporary);
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

FilledGrid filledGrid(const StoreReader& store, const ExportedVolume& volume, const VdbRequest& request,
                      const GridPlacement& place, std::uint64_t memory_bytes, Progress& progress) {
  return withVoxelType(store.manifest().type, [&]<class T>(std::type_identity<T>) {
    const auto filled = [&]<class Grid>(std::type_identity<Grid>) {
      requireValuesFit<Grid>(store.manifest(), request);
      return gridOf<T, Grid>(store, volume, request, place, memory_bytes, progress);
    };
    // Labels are whole numbers, exported in the integer type that Kiln can read back.
    if (store.manifest().volume_class == VolumeClass::kLabels) return filled(std::type_identity<openvdb::Int32Grid>());
    if (request.values.type != VdbType::kExact) return filled(std::type_identity<openvdb::FloatGrid>());
    return filled(std::type_identity<GridFor<T>>());
  });
}

void requireLabelsKept(const StoreReader& store, const VdbRequest& request) {
  if (store.manifest().volume_class != VolumeClass::kLabels) return;
  if (store.manifest().range.hi > 2147483647.0)
    throw Error(ErrorCode::kUnsupported, request.out, "",
                "labels beyond 2147483647 have no OpenVDB grid that others read");
  if (request.values.type != VdbType::kExact || request.values.tolerance != 0)
    throw Error(ErrorCode::kUsage, request.out, request.values.tolerance != 0 ? "--tolerance" : "--type",
                "is for measured values, and this store holds labels; leave it out");
}

}  // namespace

VdbReport exportVdb(const StoreReader& store, const ExportedVolume& volume, const VdbRequest& request,
                    Progress& progress, FileSystem& disk) {
  if (!request.overwrite && isThere(request.out)) {
    throw Error(ErrorCode::kExists, request.out, "", "is there already; name another output or give --overwrite");
  }
  requireLabelsKept(store, request);
  disk.requirePlaceToRename(request.out);
  initializeOpenVdb();
  const GridPlacement place = placementOf(store, volume.level, request.out);
  const std::uint64_t memory_bytes = request.memory_bytes - std::min(request.memory_bytes, store.index().bytes());
  const FilledGrid filled = filledGrid(store, volume, request, place, memory_bytes, progress);
  VdbReport report;
  report.voxels = filled.grid->activeVoxelCount();
  report.largest_error = filled.largest_error;
  publish(filled.grid, request.out, disk);
  report.bytes = File(request.out).size();
  return report;
}

}  // namespace kiln
