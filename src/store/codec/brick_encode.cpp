// Encodes voxels as a brick file.
// Method. Leaves are packed directly from the voxels, without a tree.
// Invariant. Exactly the voxels of core and apron are active, whatever their values, and the bytes depend only on the
// voxels.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "base/error.h"
#include "base/hash.h"
#include "store/codec/brick_archive.h"
#include "store/codec/brick_file.h"
#include "store/codec/half_values.h"
#include "store/codec/leaf_turn.h"

namespace kiln {
namespace {

constexpr std::size_t kUuidAt = 21;
constexpr std::size_t kUuidLength = 36;

// Converts an affine to units of 2^exponent.
glm::dmat4 inUnits(int exponent, const glm::dmat4& world_from_grid) {
  glm::dmat4 units_from_world(std::ldexp(1.0, -exponent));
  units_from_world[3][3] = 1;
  return units_from_world * world_from_grid;
}

// Returns 0, or, if OpenVDB refuses the level's affine, an exponent that makes a voxel edge about 1 (FORMAT.md).
int unitExponentOf(const VolumeGeometry& geometry, const std::filesystem::path& source = {}) {
  if (hasTransform(geometry.world_from_index)) return 0;
  const int exponent = std::ilogb(geometry.meanSpacing());
  if (hasTransform(inUnits(exponent, geometry.world_from_index))) return exponent;
  const glm::dvec3 edge = geometry.spacing(), origin = geometry.worldOf({0, 0, 0});
  throw Error(ErrorCode::kUnsupported, source, "geometry",
              fmt::format("voxels of {:g} x {:g} x {:g} world units are lost to rounding as far from 0 as "
                          "({:g}, {:g}, {:g}); give the source an origin nearer to 0",
                          edge.x, edge.y, edge.z, origin.x, origin.y, origin.z));
}

template <class T>
class Encoder {
 public:
  Encoder(const BrickDesc& frame, std::span<const std::byte> voxels)
      : frame_(frame),
        core_(frame.core()),
        box_(frame.stored()),
        size_(box_.extent()),
        voxels_(reinterpret_cast<const T*>(voxels.data())),
        half_(fitsHalf()),
        unit_exponent_(unitExponentOf(frame.geometry)) {}

  // Grid of the core or of the apron.
  PackedGrid voxelGrid(const char* name, bool core) const {
    if constexpr (kMayBeHalf) {
      if (half_) return packVoxels<openvdb::FloatGrid>(name, core, true, halfBitsOf);
    }
    return packVoxels<BrickGridFor<T>>(name, core, false,
                                       [](T value) { return static_cast<typename BrickGridFor<T>::ValueType>(value); });
  }

  PackedGrid cellGrid(const char* name, std::span<const ValueRange> cells, bool least) const {
    // On coarser levels cells hold values of finer voxels, which may not survive as halves although the brick's own
    // values do.
    const bool half = half_ && std::all_of(cells.begin(), cells.end(), [](const ValueRange& cell) {
                        return cell.empty() ||
                               (survivesHalf(static_cast<float>(cell.lo)) && survivesHalf(static_cast<float>(cell.hi)));
                      });
    if (half) {
      return packCells<openvdb::FloatGrid>(name, cells, least, true,
                                           [](float value) { return openvdb::math::half(value); });
    }
    return packCells<BrickGridFor<T>>(name, cells, least, false, [](auto value) { return value; });
  }

 private:
  static constexpr bool kMayBeHalf = std::is_same_v<BrickGridFor<T>, openvdb::FloatGrid>;

  bool fitsHalf() const {
    if constexpr (kMayBeHalf) return fitHalf({voxels_, static_cast<std::size_t>(size_.count())});
    return false;
  }

  struct LeafPart {
    VoxelCoord origin;
    VoxelBox part;
  };

  template <class Grid, class F>
  PackedGrid packVoxels(const char* name, bool core, bool half, F storedOf) const {
    using Stored = std::invoke_result_t<F, T>;
    const VoxelBox& box = core ? core_ : box_;
    std::vector<LeafPart> leaves;
    forEachLeafOfGrid(core_, box_, core, [&](const VoxelCoord& origin, const VoxelBox& part) {
      leaves.push_back({origin, part});
    });
    PackedGrid out{makeGrid<Grid>(name, frame_.geometry.world_from_index, half),
                   {leaves.size(), sizeof(typename Grid::ValueType)}};
    const std::unique_ptr<const T[]> values = inOrderOf(leaves, box);
    const T* next = values.get();
    for (const auto& [origin, part] : leaves) {
      const auto count = static_cast<std::size_t>(part.count());
      Stored stored[kLeaf * kLeaf * kLeaf];
      std::transform(next, next + count, stored, storedOf);
      out.leaves.add({coordOf(origin), maskOf(origin, part)}, stored, sizeof(Stored), count);
      next += count;
    }
    return out;
  }

  // Cell c covers the voxels [8c, 8c+8), so its centre is at voxel 8c + 3.5.
  glm::dmat4 worldFromCell() const {
    const double s = static_cast<double>(kCellSize);
    glm::dmat4 index_from_cell(s);
    index_from_cell[3] = glm::dvec4(glm::dvec3((s - 1) / 2), 1.0);
    return frame_.geometry.world_from_index * index_from_cell;
  }

  template <class Grid, class F>
  PackedGrid packCells(const char* name, std::span<const ValueRange> cells, bool least, bool half, F storedOf) const {
    using Value = typename Grid::ValueType;
    using Stored = std::invoke_result_t<F, Value>;
    const std::int64_t edge = frame_.brick_size / kCellSize;
    const VoxelCoord lo = {core_.lo.x / kCellSize, core_.lo.y / kCellSize, core_.lo.z / kCellSize};
    const VoxelBox box = {lo, {lo.x + edge, lo.y + edge, lo.z + edge}};
    const std::int64_t across = edge / kLeaf + 1;
    PackedGrid out{makeGrid<Grid>(name, worldFromCell(), half),
                   {static_cast<std::size_t>(across * across * across), sizeof(Value)}};
    forEachLeafOfTree(box, [&](const VoxelCoord& origin, const VoxelBox& part) {
      PackedLeaves::Leaf leaf{coordOf(origin), {}};
      Stored stored[kLeaf * kLeaf * kLeaf];
      std::size_t count = 0;
      forCubes(part, 1, [&](const VoxelCoord& at, const VoxelBox&) {
        const ValueRange& cell =
            cells[static_cast<std::size_t>(((at.z - lo.z) * edge + (at.y - lo.y)) * edge + (at.x - lo.x))];
        if (cell.empty()) return;
        leaf.active.setOn(openvdb::FloatTree::LeafNodeType::coordToOffset(coordOf(at)));
        stored[count++] = storedOf(static_cast<Value>(least ? cell.lo : cell.hi));
      });
      if (count > 0) out.leaves.add(leaf, stored, sizeof(Stored), count);
    });
    return out;
  }

  // Values of the leaves, leaf by leaf. Voxels are read in the memory order of the block: reading leaf by leaf would
  // load each cache line four times.
  std::unique_ptr<const T[]> inOrderOf(std::span<const LeafPart> leaves, const VoxelBox& box) const {
    const LeafLattice lattice(box);
    std::vector<std::int64_t> begin(lattice.count(), -1);
    std::int64_t end = 0;
    for (const auto& [origin, part] : leaves) {
      begin[lattice.indexOf(part.lo)] = end;
      end += part.count();
    }
    auto values = std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(end));
    forEachLeaf(box, [&](const VoxelBox& part) {
      const std::int64_t at = begin[lattice.indexOf(part.lo)];
      if (at >= 0) transposeLeaf(part, values.get() + at);
    });
    return values;
  }

  // Copies the voxels of a leaf inside the box from the block (x fastest) to the leaf (z fastest).
  void transposeLeaf(const VoxelBox& part, T* to) const {
    const Extent3 n = part.extent();
    const std::int64_t row = size_.x, slice = size_.x * size_.y;
    const T* const from =
        voxels_ + (part.lo.z - box_.lo.z) * slice + (part.lo.y - box_.lo.y) * row + (part.lo.x - box_.lo.x);
    if (n == Extent3{kLeaf, kLeaf, kLeaf}) {
      for (std::int64_t y = 0; y < kLeaf; ++y) transposeSquare(from + y * row, slice, to + y * kLeaf, kLeaf * kLeaf);
      return;
    }
    T rows[kLeaf * kLeaf] = {}, columns[kLeaf * kLeaf];
    for (std::int64_t y = 0; y < n.y; ++y) {
      for (std::int64_t z = 0; z < n.z; ++z) std::copy_n(from + z * slice + y * row, n.x, rows + z * kLeaf);
      transposeSquare(rows, kLeaf, columns, kLeaf);
      for (std::int64_t x = 0; x < n.x; ++x) std::copy_n(columns + x * kLeaf, n.z, to + (x * n.y + y) * n.z);
    }
  }

  template <class Grid>
  typename Grid::Ptr makeGrid(const char* name, const glm::dmat4& world_from_grid, bool half) const {
    typename Grid::Ptr grid = newGrid<Grid>(0);
    grid->setName(name);
    if (unit_exponent_ == 0) {
      grid->setTransform(transformOf(world_from_grid));
    } else {
      grid->setTransform(transformOf(inUnits(unit_exponent_, world_from_grid)));
      grid->insertMeta(kUnitExponent, openvdb::Int32Metadata(unit_exponent_));
    }
    grid->setSaveFloatAsHalf(half);
    return grid;
  }

  const BrickDesc& frame_;
  VoxelBox core_, box_;
  Extent3 size_;
  const T* voxels_;
  bool half_;
  int unit_exponent_;
};

// Replaces OpenVDB's random UUID by a hash of the contents.
void stampUuid(std::vector<std::byte>& file) {
  std::memset(file.data() + kUuidAt, '0', kUuidLength);
  const std::string hex = toHex(hashOf(file));
  const std::string uuid = fmt::format("{}-{}-{}-{}-{}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                                       hex.substr(16, 4), hex.substr(20, 12));
  std::memcpy(file.data() + kUuidAt, uuid.data(), kUuidLength);
}

}  // namespace

void requireTransform(const VolumeGeometry& geometry, const std::filesystem::path& source) {
  unitExponentOf(geometry, source);
}

std::vector<std::byte> encodeBrick(const BrickDesc& frame, std::span<const std::byte> voxels,
                                   std::span<const ValueRange> cells) {
  initializeOpenVdb();
  return withVoxelType(frame.type, [&]<class T>(std::type_identity<T>) {
    const Encoder<T> encoder(frame, voxels);
    const std::array<PackedGrid, 4> grids = {encoder.voxelGrid(kCoreGrid, true), encoder.voxelGrid(kApronGrid, false),
                                             encoder.cellGrid(kCellMinGrid, cells, true),
                                             encoder.cellGrid(kCellMaxGrid, cells, false)};
    std::vector<std::byte> file = archiveOf(grids, metadataOf(frame));
    stampUuid(file);
    return file;
  });
}

std::string containerVersion() { return std::string("OpenVDB ") + openvdb::getLibraryVersionString(); }

}  // namespace kiln
