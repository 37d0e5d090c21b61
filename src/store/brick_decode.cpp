// A brick file, or the one value of a brick that has no file, to voxels. The file has passed its checksum, so what is
// wrong with it is its writer's defect, and an error all the same.
#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <algorithm>
#include <array>
#include <istream>
#include <memory>
#include <streambuf>
#include <string_view>

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

// The parts of a file one after the other, as Archive::readGrid takes them, but for the leaves' values.
class ArchiveReader : public openvdb::io::Archive {
 public:
  // Calls take(grid) for each grid; its topology is there, and the stream stands at the values of its first leaf.
  template <class Take>
  void read(std::istream& in, const openvdb::MetaMap& expected, const std::filesystem::path& path, Take&& take) {
    readHeader(in);
    // OpenVDB's own readers ask the stream for these.
    auto versions = std::make_shared<openvdb::io::StreamMetadata>();
    openvdb::io::setStreamMetadataPtr(in, versions, /*transfer=*/false);
    setFormatVersion(in);
    setLibraryVersion(in);
    setDataCompression(in);
    openvdb::MetaMap found;
    found.readMeta(in);
    if (!(found == expected))
      throw Error(ErrorCode::kDamaged, path, "metadata", "the file is another brick's; convert the source again");
    const std::int32_t count = readGridCount(in);
    for (std::int32_t i = 0; i < count; ++i) {
      openvdb::io::GridDescriptor descriptor;
      const openvdb::GridBase::Ptr grid = descriptor.read(in);
      readGridCompression(in);
      openvdb::io::setGridBackgroundValuePtr(in, nullptr);
      grid->readMeta(in);
      openvdb::io::setGridClass(in, grid->getGridClass());
      grid->readTransform(in);
      grid->readTopology(in);
      grid->setName(openvdb::io::GridDescriptor::stripSuffix(descriptor.gridName()));
      take(*grid);
    }
    openvdb::io::clearStreamMetadataPtr(in);
  }
};

// Calls f(leaf) for each leaf of a grid, with its values. They are read for one leaf at a time: a tree of all of them
// would take more memory than the brick.
template <class Grid, class F>
void forEachLeaf(Grid& grid, std::istream& in, F&& f) {
  typename Grid::TreeType::LeafNodeType::Buffer values(openvdb::PartialCreate(), grid.background());
  for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) {
    leaf->swap(values);
    leaf->readBuffers(in, grid.saveFloatAsHalf());
    f(*leaf);
    leaf->swap(values);
  }
}

template <class T>
class Decoder {
 public:
  Decoder(const BrickFrame& frame, const std::filesystem::path& path, std::istream& in, BrickBlock& block)
      : core_(frame.core()),
        stored_(frame.stored()),
        edge_(static_cast<int>(frame.brick_size / kCellSize)),
        cells_(static_cast<std::size_t>(edge_) * edge_ * edge_),
        path_(path),
        in_(in),
        block_(block) {}

  void take(openvdb::GridBase& base) {
    const auto known = std::find(kGrids.begin(), kGrids.end(), base.getName());
    if (known == kGrids.end()) fail(base.getName() + " is no grid of a brick");
    const auto which = static_cast<std::size_t>(known - kGrids.begin());
    if (std::exchange(taken_[which], true)) fail(base.getName() + " is there twice");
    if (!takeAs<BrickGridFor<T>>(base, which) && !takeAs<GridFor<T>>(base, which))
      fail(base.getName() + " holds " + base.valueType());
  }

  // To be called when all grids are taken.
  void finish() {
    for (std::size_t i = 0; i < kGrids.size(); ++i) {
      if (!taken_[i]) fail("the grid " + std::string(kGrids[i]) + " is missing");
    }
    clampEdges();
    block_.octree = MinMaxOctree(std::move(cells_), edge_);
  }

 private:
  static constexpr std::array<std::string_view, 4> kGrids = {kCoreGrid, kApronGrid, kCellMinGrid, kCellMaxGrid};

  template <class Grid>
  bool takeAs(openvdb::GridBase& base, std::size_t which) {
    auto* const grid = dynamic_cast<Grid*>(&base);
    if (grid == nullptr) return false;
    if (which < 2)
      takeVoxels(*grid, which == 0);
    else
      takeCells(*grid, which == 2);
    return true;
  }

  template <class Grid>
  void takeVoxels(Grid& grid, bool core) {
    T* const voxels = reinterpret_cast<T*>(block_.voxels.data());
    const VoxelBox& box = core ? core_ : stored_;
    std::int64_t count = 0;
    forEachLeaf(grid, in_, [&](const auto& leaf) {
      const VoxelCoord origin = voxelOf(leaf.origin());
      // No leaf has voxels of both core and apron.
      const VoxelBox part = intersection(leafAt(origin), box);
      if (part.empty() || (!core && core_.contains(part.lo)) || leaf.valueMask() != maskOf(origin, part))
        fail(grid.getName() + " has a voxel outside of its place, or lacks one");
      copyLeaf(leaf.buffer().data(), origin, part, voxels);
      count += part.count();
    });
    const std::int64_t expected = core ? core_.count() : stored_.count() - core_.count();
    if (count != expected) fail(fmt::format("{} has {} voxels, expected {}", grid.getName(), count, expected));
  }

  template <class Grid>
  void takeCells(Grid& grid, bool least) {
    forEachLeaf(grid, in_, [&](const auto& leaf) {
      for (auto voxel = leaf.cbeginValueOn(); voxel; ++voxel) {
        const openvdb::Coord c = voxel.getCoord();
        const std::int64_t x = c.x() - core_.lo.x / kCellSize;
        const std::int64_t y = c.y() - core_.lo.y / kCellSize;
        const std::int64_t z = c.z() - core_.lo.z / kCellSize;
        if (!boxOf({edge_, edge_, edge_}).contains({x, y, z}))
          fail(grid.getName() + " has a cell outside of its place");
        ValueRange& range = cells_[static_cast<std::size_t>((z * edge_ + y) * edge_ + x)];
        (least ? range.lo : range.hi) = static_cast<double>(*voxel);
      }
    });
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
        const std::int64_t first = stored_.lo.x - all.lo.x, end = stored_.hi.x - all.lo.x;
        std::fill(row, row + first, row[first]);
        std::fill(row + end, row + n.x, row[end - 1]);
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

  // From z fastest to x fastest.
  template <class Value>
  void copyLeaf(const Value* from, const VoxelCoord& origin, const VoxelBox& part, T* voxels) const {
    const Extent3 n = part.extent();
    for (std::int64_t z = 0; z < n.z; ++z) {
      for (std::int64_t y = 0; y < n.y; ++y) {
        T* const to = voxels + block_.offsetOf({part.lo.x, part.lo.y + y, part.lo.z + z});
        const Value* const row =
            from + ((part.lo.x - origin.x) << 6 | (part.lo.y - origin.y + y) << 3 | (part.lo.z - origin.z + z));
        for (std::int64_t x = 0; x < n.x; ++x) to[x] = static_cast<T>(row[x << 6]);
      }
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kDamaged, path_, "", what + "; convert the source again");
  }

  VoxelBox core_, stored_;
  int edge_;  // cells along an axis
  std::vector<ValueRange> cells_;
  std::array<bool, 4> taken_{};
  const std::filesystem::path& path_;
  std::istream& in_;
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

CellSupports supportsOf(const BrickBlock& block) {
  return CellSupports(block.voxels, block.type, block.extent, block.core.lo, block.octree.edge(0));
}

}  // namespace

BrickBlock decodeBrick(const BrickFrame& frame, std::span<const std::byte> file, const std::filesystem::path& path) {
  initializeOpenVdb();
  try {
    MemoryReader buffer(file);
    std::istream in(&buffer);
    in.exceptions(std::ios::failbit | std::ios::badbit);
    BrickBlock block = emptyBlock(frame);
    withVoxelType(frame.type, [&]<class T>(std::type_identity<T>) {
      Decoder<T> decoder(frame, path, in, block);
      ArchiveReader().read(in, metadataOf(frame), path, [&](openvdb::GridBase& grid) { decoder.take(grid); });
      decoder.finish();
    });
    block.supports = supportsOf(block);
    return block;
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
  block.supports = supportsOf(block);
  return block;
}

std::size_t blockBytes(const BrickFrame& frame) {
  const std::int64_t edge = frame.brick_size / kCellSize;
  const auto octree = static_cast<std::size_t>(edge * edge * edge * 8 / 7 + 1) * sizeof(ValueRange);
  return sizeof(BrickBlock) +
         static_cast<std::size_t>(dilated(frame.core(), frame.apron).count()) * sizeOf(frame.type) + octree +
         CellSupports::bytesFor(edge);
}

std::size_t decodeBytes(const BrickFrame& frame) {
  // One grid's tree at a time, without its values: a leaf takes some 100 bytes, the nodes above it 8 a child and two
  // masks. Bricks and their aprons lie on both sides of the nodes' borders.
  const VoxelBox stored = frame.stored();
  const auto nodes = [&](std::int64_t edge) {
    std::int64_t count = 1;
    for (int axis = 0; axis < 3; ++axis) count *= (stored.hi[axis] - 1) / edge - stored.lo[axis] / edge + 1;
    return static_cast<std::size_t>(count);
  };
  const std::size_t tree = nodes(kLeaf) * 160 + nodes(128) * (34u << 10) + nodes(4096) * (265u << 10);
  const std::size_t block = static_cast<std::size_t>(dilated(frame.core(), frame.apron).count()) * sizeOf(frame.type);
  // The tree has gone when cells' supports are computed.
  const std::int64_t edge = frame.brick_size / kCellSize;
  const std::size_t supports =
      CellSupports::bytesFor(edge) + CellSupports::scratchBytes(frame.brick_size, frame.apron, frame.type);
  return std::max(tree, supports) + CellSupports::bytesFor(edge) + block + (std::size_t{1} << 18);
}

}  // namespace kiln
