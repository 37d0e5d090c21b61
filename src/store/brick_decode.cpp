// A brick file, or the one value of a brick that has no file, to voxels. The file has passed its checksum, so what is
// wrong with it is its writer's defect, and an error all the same.
#include <fmt/format.h>
#include <openvdb/io/Stream.h>

#include <algorithm>
#include <istream>
#include <streambuf>

#include "base/error.h"
#include "store/brick_file.h"

namespace kiln {
namespace {

class MemoryReader : public std::streambuf {
 public:
  explicit MemoryReader(std::span<const std::byte> data) {
    // setg wants non-const; nothing writes through it.
    char* first = const_cast<char*>(reinterpret_cast<const char*>(data.data()));
    setg(first, first, first + data.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    char* const base = from == std::ios_base::beg ? eback() : from == std::ios_base::cur ? gptr() : egptr();
    if (offset < eback() - base || offset > egptr() - base) return pos_type(off_type(-1));
    setg(eback(), base + offset, egptr());
    return static_cast<pos_type>(gptr() - eback());
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(static_cast<off_type>(position), std::ios_base::beg, mode);
  }
};

template <class T>
class Decoder {
 public:
  using Grid = GridFor<T>;

  Decoder(const BrickFrame& frame, const std::filesystem::path& path, BrickBlock& block)
      : core_(frame.core()), stored_(frame.stored()), path_(path), block_(block) {}

  void take(const openvdb::GridBase& base, bool core) {
    const auto* grid = dynamic_cast<const Grid*>(&base);
    if (grid == nullptr) fail(base.getName() + " holds " + base.valueType());
    T* const voxels = reinterpret_cast<T*>(block_.voxels.data());
    std::int64_t count = 0;
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
      const openvdb::Coord& origin = leaf->origin();
      for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel) {
        const openvdb::Index n = voxel.pos();
        const VoxelCoord v = {origin.x() + (n >> 6), origin.y() + ((n >> 3) & 7), origin.z() + (n & 7)};
        if (!stored_.contains(v) || core_.contains(v) != core)
          fail(base.getName() + " has a voxel outside of its place");
        voxels[block_.offsetOf(v)] = static_cast<T>(*voxel);
        ++count;
      }
    }
    const std::int64_t expected = core ? core_.count() : stored_.count() - core_.count();
    if (count != expected) fail(fmt::format("{} has {} voxels, expected {}", base.getName(), count, expected));
  }

  void takeCells(const openvdb::GridBase& base, std::vector<ValueRange>& cells, int edge, bool least) {
    const auto* grid = dynamic_cast<const Grid*>(&base);
    if (grid == nullptr) fail(base.getName() + " holds " + base.valueType());
    for (auto voxel = grid->cbeginValueOn(); voxel; ++voxel) {
      const openvdb::Coord c = voxel.getCoord();
      const std::int64_t x = c.x() - core_.lo.x / kCellSize;
      const std::int64_t y = c.y() - core_.lo.y / kCellSize;
      const std::int64_t z = c.z() - core_.lo.z / kCellSize;
      if (!voxel.isVoxelValue() || !boxOf({edge, edge, edge}).contains({x, y, z}))
        fail(base.getName() + " has a cell outside of its place");
      ValueRange& range = cells[static_cast<std::size_t>((z * edge + y) * edge + x)];
      (least ? range.lo : range.hi) = static_cast<double>(*voxel);
    }
  }

  // Voxels of the extent that lie outside of the volume repeat the nearest one inside, axis by axis.
  void clampEdges() {
    T* const voxels = reinterpret_cast<T*>(block_.voxels.data());
    const VoxelBox& all = block_.extent;
    const Extent3 n = all.extent();
    const auto nearest = [&](std::int64_t i, int axis) {
      return std::clamp(i, stored_.lo[axis], stored_.hi[axis] - 1) - all.lo[axis];
    };
    for (std::int64_t z = stored_.lo.z; z < stored_.hi.z; ++z) {
      for (std::int64_t y = stored_.lo.y; y < stored_.hi.y; ++y) {
        T* const row = voxels + ((z - all.lo.z) * n.y + (y - all.lo.y)) * n.x;
        for (std::int64_t x = 0; x < n.x; ++x) row[x] = row[nearest(x + all.lo.x, 0)];
      }
      T* const slice = voxels + (z - all.lo.z) * n.y * n.x;
      for (std::int64_t y = 0; y < n.y; ++y) {
        const std::int64_t from = nearest(y + all.lo.y, 1);
        if (from != y) std::copy_n(slice + from * n.x, n.x, slice + y * n.x);
      }
    }
    for (std::int64_t z = 0; z < n.z; ++z) {
      const std::int64_t from = nearest(z + all.lo.z, 2);
      if (from != z) std::copy_n(voxels + from * n.y * n.x, n.y * n.x, voxels + z * n.y * n.x);
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kDamaged, path_, "", what + "; convert the source again");
  }

 private:
  VoxelBox core_, stored_;
  const std::filesystem::path& path_;
  BrickBlock& block_;
};

BrickBlock emptyBlock(const BrickFrame& frame) {
  BrickBlock block;
  block.key = frame.key;
  block.type = frame.type;
  block.core = frame.core();
  block.extent = dilated(block.core, frame.apron);
  block.voxels.resize(static_cast<std::size_t>(block.extent.count()) * sizeOf(frame.type));
  return block;
}

openvdb::GridBase::Ptr gridNamed(const openvdb::GridPtrVec& grids, const char* name,
                                 const std::filesystem::path& path) {
  for (const auto& grid : grids) {
    if (grid && grid->getName() == name) return grid;
  }
  throw Error(ErrorCode::kDamaged, path, name, "the grid is missing; convert the source again");
}

template <class T>
BrickBlock decodeTyped(const BrickFrame& frame, openvdb::GridPtrVec& grids, const std::filesystem::path& path) {
  BrickBlock block = emptyBlock(frame);
  Decoder<T> decoder(frame, path, block);
  decoder.take(*gridNamed(grids, kCoreGrid, path), true);
  decoder.take(*gridNamed(grids, kApronGrid, path), false);
  decoder.clampEdges();
  const int edge = static_cast<int>(frame.brick_size / kCellSize);
  std::vector<ValueRange> cells(static_cast<std::size_t>(edge) * edge * edge);
  decoder.takeCells(*gridNamed(grids, kCellMinGrid, path), cells, edge, true);
  decoder.takeCells(*gridNamed(grids, kCellMaxGrid, path), cells, edge, false);
  block.octree = MinMaxOctree(std::move(cells), edge);
  return block;
}

}  // namespace

BrickBlock decodeBrick(const BrickFrame& frame, std::span<const std::byte> file, const std::filesystem::path& path) {
  initializeOpenVdb();
  try {
    MemoryReader buffer(file);
    std::istream in(&buffer);
    in.exceptions(std::ios::failbit | std::ios::badbit);
    openvdb::io::Stream stream(in, /*delayLoad=*/false);
    if (!(*stream.getMetadata() == metadataOf(frame))) {
      throw Error(ErrorCode::kDamaged, path, "metadata", "the file is another brick's; convert the source again");
    }
    openvdb::GridPtrVecPtr grids = stream.getGrids();
    return withVoxelType(frame.type,
                         [&]<class T>(std::type_identity<T>) { return decodeTyped<T>(frame, *grids, path); });
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kDamaged, path, "OpenVDB", error.what());
  }
}

BrickBlock constantBrick(const BrickFrame& frame, double value) {
  BrickBlock block = emptyBlock(frame);
  withVoxelType(frame.type, [&]<class T>(std::type_identity<T>) {
    T* const voxels = reinterpret_cast<T*>(block.voxels.data());
    std::fill_n(voxels, block.extent.count(), static_cast<T>(value));
  });
  const int edge = static_cast<int>(frame.brick_size / kCellSize);
  block.octree = MinMaxOctree(cellRanges(block.voxels, frame.type, block.extent, block.core, edge), edge);
  return block;
}

std::size_t decodeBytes(const BrickFrame& frame) {
  // A leaf costs its 512 values and some 100 bytes; core and apron are whole leaves.
  const std::size_t value_bytes = frame.type == VoxelType::u32 || frame.type == VoxelType::f64 ? 8 : 4;
  VoxelBox leaves = frame.stored();
  for (int axis = 0; axis < 3; ++axis) {
    leaves.lo[axis] = leafBelow(leaves.lo[axis]);
    leaves.hi[axis] = leafBelow(leaves.hi[axis] + kLeaf - 1);
  }
  const std::size_t grids = static_cast<std::size_t>(leaves.count()) / 512 * (512 * value_bytes + 128);
  const std::size_t block = static_cast<std::size_t>(dilated(frame.core(), frame.apron).count()) * sizeOf(frame.type);
  return grids + block + (std::size_t{1} << 18);
}

}  // namespace kiln
