// Voxels to a brick file. Leaves are packed straight from the voxels: exactly those of core and apron are active
// whatever their value, and the bytes depend on the voxels alone.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "base/hash.h"
#include "store/brick_archive.h"
#include "store/brick_file.h"
#include "store/half_values.h"

namespace kiln {
namespace {

constexpr std::size_t kUuidAt = 21;
constexpr std::size_t kUuidLength = 36;

// Calls leaf(origin, part) for each 8³ leaf that has voxels in `box`; `part` is what of it lies in the box.
template <class F>
void forEachLeaf(const VoxelBox& box, F&& leaf) {
  for (std::int64_t z = leafBelow(box.lo.z); z < box.hi.z; z += kLeaf) {
    for (std::int64_t y = leafBelow(box.lo.y); y < box.hi.y; y += kLeaf) {
      for (std::int64_t x = leafBelow(box.lo.x); x < box.hi.x; x += kLeaf) {
        leaf(VoxelCoord{x, y, z}, intersection(leafAt({x, y, z}), box));
      }
    }
  }
}

template <class T>
struct LeafRow {
  using type [[gnu::vector_size(kLeaf * sizeof(T))]] = T;
};

// Rows of 8 values become columns; strides between rows, in values. Interleaving the first four rows with the last four
// does it, three times over.
template <class T>
void transposeSquare(const T* from, std::int64_t from_stride, T* to, std::int64_t to_stride) {
  static_assert(kLeaf == 8);
  using Row = typename LeafRow<T>::type;
  Row rows[kLeaf], turned[kLeaf];
  for (std::int64_t i = 0; i < kLeaf; ++i) std::memcpy(&rows[i], from + i * from_stride, sizeof(Row));
  for (int stage = 0; stage < 3; ++stage) {
    for (int i = 0; i < kLeaf / 2; ++i) {
      const Row first = rows[i], last = rows[i + kLeaf / 2];
      turned[2 * i] = __builtin_shufflevector(first, last, 0, 8, 1, 9, 2, 10, 3, 11);
      turned[2 * i + 1] = __builtin_shufflevector(first, last, 4, 12, 5, 13, 6, 14, 7, 15);
    }
    std::copy(std::begin(turned), std::end(turned), std::begin(rows));
  }
  for (std::int64_t i = 0; i < kLeaf; ++i) std::memcpy(to + i * to_stride, &rows[i], sizeof(Row));
}

template <class T>
class Encoder {
 public:
  Encoder(const BrickFrame& frame, std::span<const std::byte> voxels)
      : frame_(frame),
        core_(frame.core()),
        box_(frame.stored()),
        size_(box_.extent()),
        voxels_(reinterpret_cast<const T*>(voxels.data())),
        half_(fitsHalf()) {}

  // The core, or the apron.
  void voxelGrid(const char* name, bool core, PackedGrid& out) const {
    if constexpr (kMayBeHalf) {
      if (half_) return packVoxels<openvdb::FloatGrid>(name, core, true, halfBitsOf, out);
    }
    packVoxels<BrickGridFor<T>>(
        name, core, false, [](T value) { return static_cast<typename BrickGridFor<T>::ValueType>(value); }, out);
  }

  void cellGrid(const char* name, std::span<const ValueRange> cells, bool least, PackedGrid& out) const {
    // On coarser levels cells hold values of voxels below, which need not survive where the brick's own do.
    const bool half = half_ && std::all_of(cells.begin(), cells.end(), [](const ValueRange& cell) {
                        return cell.empty() ||
                               (survivesHalf(static_cast<float>(cell.lo)) && survivesHalf(static_cast<float>(cell.hi)));
                      });
    if (half)
      packCells<openvdb::FloatGrid>(name, cells, least, true, out);
    else
      packCells<BrickGridFor<T>>(name, cells, least, false, out);
  }

 private:
  static constexpr bool kMayBeHalf = std::is_same_v<BrickGridFor<T>, openvdb::FloatGrid>;

  bool fitsHalf() const {
    if constexpr (kMayBeHalf) return fitHalf({voxels_, static_cast<std::size_t>(size_.count())});
    return false;
  }

  // A core begins and ends where leaves do, or where the volume ends: no leaf has voxels of both core and apron.
  template <class Grid, class F>
  void packVoxels(const char* name, bool core, bool half, F storedOf, PackedGrid& out) const {
    using Leaf = typename Grid::TreeType::LeafNodeType;
    const typename Grid::Ptr grid = makeGrid<Grid>(name, transformOf(frame_.geometry.world_from_index), half);
    const VoxelBox& box = core ? core_ : box_;
    forEachLeaf(box, [&](const VoxelCoord& origin, const VoxelBox& part) {
      if (!core && core_.contains(part.lo)) return;
      // It has a mask and no values.
      auto leaf = std::make_unique<Leaf>(openvdb::PartialCreate(), coordOf(origin), typename Grid::ValueType(0));
      leaf->setValueMask(maskOf(origin, part));
      grid->tree().addLeaf(leaf.release());
    });
    out.grid = grid;
    addLeaves(grid->tree(), box, storedOf, out.leaves);
  }

  template <class Grid>
  void packCells(const char* name, std::span<const ValueRange> cells, bool least, bool half, PackedGrid& out) const {
    using Value = typename Grid::ValueType;
    // Cell c covers voxels [8c, 8c+8): its centre is at voxel 8c + 3.5.
    const double s = static_cast<double>(kCellSize);
    glm::dmat4 index_from_cell(s);
    index_from_cell[3] = glm::dvec4(glm::dvec3((s - 1) / 2), 1.0);
    const typename Grid::Ptr grid =
        makeGrid<Grid>(name, transformOf(frame_.geometry.world_from_index * index_from_cell), half);
    const int edge = static_cast<int>(frame_.brick_size / kCellSize);
    auto accessor = grid->getAccessor();
    std::size_t i = 0;
    for (int z = 0; z < edge; ++z) {
      for (int y = 0; y < edge; ++y) {
        for (int x = 0; x < edge; ++x, ++i) {
          if (cells[i].empty()) continue;
          const double value = least ? cells[i].lo : cells[i].hi;
          accessor.setValueOn(
              coordOf({core_.lo.x / kCellSize + x, core_.lo.y / kCellSize + y, core_.lo.z / kCellSize + z}),
              static_cast<Value>(value));
        }
      }
    }
    out.grid = grid;
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
      std::vector<Value> values;
      for (auto value = leaf->cbeginValueOn(); value; ++value) values.push_back(*value);
      if constexpr (std::is_same_v<Grid, openvdb::FloatGrid>) {
        if (half) {
          const std::vector<openvdb::math::half> halves(values.begin(), values.end());
          out.leaves.add(leaf->valueMask(), halves.data(), sizeof halves[0], halves.size());
          continue;
        }
      }
      out.leaves.add(leaf->valueMask(), values.data(), sizeof(Value), values.size());
    }
  }

  // Of each leaf the voxels that are in the box, from x fastest to z fastest.
  template <class Tree, class F>
  void addLeaves(const Tree& tree, const VoxelBox& box, F storedOf, PackedLeaves& out) const {
    using Stored = std::invoke_result_t<F, T>;
    out.reserve(tree.leafCount(), sizeof(Stored));
    const std::unique_ptr<const T[]> values = inOrderOf(tree, box);
    const T* next = values.get();
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
      const auto count = static_cast<std::size_t>(leaf->onVoxelCount());
      Stored stored[kLeaf * kLeaf * kLeaf];
      std::transform(next, next + count, stored, storedOf);
      out.add(leaf->valueMask(), stored, sizeof(Stored), count);
      next += count;
    }
  }

  // The values of the tree's leaves, one leaf after the other. Voxels are taken in the order in which they lie in the
  // block: leaf by leaf, the tree would come back to each cache line of it four times, long after.
  template <class Tree>
  std::unique_ptr<const T[]> inOrderOf(const Tree& tree, const VoxelBox& box) const {
    const auto leafIndex = [&](const VoxelCoord& voxel, int axis) {
      return voxel[axis] / kLeaf - box.lo[axis] / kLeaf;
    };
    const Extent3 n = {leafIndex(box.hi, 0) + 1, leafIndex(box.hi, 1) + 1, leafIndex(box.hi, 2) + 1};
    const auto indexOf = [&](const VoxelCoord& voxel) {
      return static_cast<std::size_t>((leafIndex(voxel, 2) * n.y + leafIndex(voxel, 1)) * n.x + leafIndex(voxel, 0));
    };
    std::vector<std::int64_t> begin(static_cast<std::size_t>(n.count()), -1);
    std::int64_t end = 0;
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
      begin[indexOf(voxelOf(leaf->origin()))] = end;
      end += static_cast<std::int64_t>(leaf->onVoxelCount());
    }
    auto values = std::make_unique_for_overwrite<T[]>(static_cast<std::size_t>(end));
    forEachLeaf(box, [&](const VoxelCoord& origin, const VoxelBox& part) {
      const std::int64_t at = begin[indexOf(origin)];
      if (at >= 0) transposeLeaf(part, values.get() + at);
    });
    return values;
  }

  // Voxels of the block, x fastest, to those of a leaf, z fastest: of what of the leaf lies in the box.
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
  typename Grid::Ptr makeGrid(const char* name, openvdb::math::Transform::Ptr transform, bool half) const {
    typename Grid::Ptr grid = newGrid<Grid>(0);
    grid->setName(name);
    grid->setTransform(std::move(transform));
    grid->setSaveFloatAsHalf(half);
    return grid;
  }

  const BrickFrame& frame_;
  VoxelBox core_, box_;
  Extent3 size_;
  const T* voxels_;
  bool half_;
};

// OpenVDB's random UUID becomes the content's own.
void stampUuid(std::vector<std::byte>& file) {
  std::memset(file.data() + kUuidAt, '0', kUuidLength);
  const std::string hex = toHex(hashOf(file));
  const std::string uuid = fmt::format("{}-{}-{}-{}-{}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                                       hex.substr(16, 4), hex.substr(20, 12));
  std::memcpy(file.data() + kUuidAt, uuid.data(), kUuidLength);
}

}  // namespace

std::vector<std::byte> encodeBrick(const BrickFrame& frame, std::span<const std::byte> voxels,
                                   std::span<const ValueRange> cells) {
  initializeOpenVdb();
  return withVoxelType(frame.type, [&]<class T>(std::type_identity<T>) {
    const Encoder<T> encoder(frame, voxels);
    std::array<PackedGrid, 4> grids;
    encoder.voxelGrid(kCoreGrid, true, grids[0]);
    encoder.voxelGrid(kApronGrid, false, grids[1]);
    encoder.cellGrid(kCellMinGrid, cells, true, grids[2]);
    encoder.cellGrid(kCellMaxGrid, cells, false, grids[3]);
    std::vector<std::byte> file = archiveOf(grids, metadataOf(frame));
    stampUuid(file);
    return file;
  });
}

std::string containerVersion() { return std::string("OpenVDB ") + openvdb::getLibraryVersionString(); }

}  // namespace kiln
