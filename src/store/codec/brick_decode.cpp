// Decodes a brick file, or makes a constant brick, which has no file.
// The file matches its checksum, so a defect is the writer's, and nevertheless an error.
#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <istream>
#include <memory>
#include <streambuf>
#include <string_view>

#include "base/error.h"
#include "base/refusal.h"
#include "grid/vdb_lengths.h"
#include "store/codec/brick_archive.h"
#include "store/codec/brick_file.h"
#include "store/codec/dense_brick.h"
#include "store/codec/half_values.h"
#include "store/codec/leaf_frame.h"
#include "store/codec/leaf_turn.h"

namespace kiln {
namespace {

class MemoryReader : public std::streambuf {
 public:
  explicit MemoryReader(std::span<const std::byte> data) {
    // setg needs a non-const pointer; the buffer is never written.
    char* first = const_cast<char*>(reinterpret_cast<const char*>(data.data()));
    setg(first, first, first + data.size());
  }
  std::span<const std::byte> rest() const { return std::as_bytes(std::span<const char>(gptr(), egptr())); }
  /// requires: no more than the rest.
  void skip(std::size_t bytes) { setg(eback(), gptr() + bytes, egptr()); }

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

// Prefetches up to `bytes` bytes from offset `at`.
void prefetchBytes(std::span<const std::byte> from, std::size_t at, std::size_t bytes) {
  constexpr std::size_t kLine = 64;
  const std::size_t end = std::min(from.size(), at + bytes);
  for (; at < end; at += kLine) __builtin_prefetch(from.data() + at);
}

openvdb::Index32 readNumber(std::istream& in) {
  openvdb::Index32 out = 0;
  in.read(reinterpret_cast<char*>(&out), sizeof out);
  return out;
}

// Reads as MetaMap::readMeta, but skips unknown types and the hint for delayed loading. OpenVDB unpacks the hint with
// Blosc, which does not check its allocations.
void readGridMetadata(openvdb::GridBase& grid, std::istream& in) {
  for (openvdb::Index32 left = readNumber(in); left > 0; --left) {
    const openvdb::Name name = openvdb::readString(in), type = openvdb::readString(in);
    if (type == kDelayedLoadType || !openvdb::Metadata::isRegisteredType(type)) {
      in.seekg(readNumber(in), std::ios_base::cur);
      continue;
    }
    const openvdb::Metadata::Ptr value = openvdb::Metadata::createMetadata(type);
    value->read(in);
    grid.insertMeta(name, *value);
  }
}

// Reads the parts of a file in order, as Archive::readGrid does, but without trees.
class ArchiveReader : public openvdb::io::Archive {
 public:
  // Calls take(grid, nodes_are_plain) for each grid while the stream is at the grid's topology; `take` moves the stream
  // behind the last leaf. nodes_are_plain() walks the tree, and returns whether OpenVDB may read its nodes.
  template <class Take>
  void read(std::span<const std::byte> file, std::istream& in, const openvdb::MetaMap& expected,
            const std::filesystem::path& path, Take&& take) {
    VdbLengths lengths({path, ErrorCode::kDamaged, file.size(), [file](std::uint64_t at, std::span<std::byte> out) {
                          std::copy_n(file.begin() + static_cast<std::ptrdiff_t>(at), out.size(), out.begin());
                        }});
    const auto position = [&in] { return static_cast<std::uint64_t>(std::streamoff(in.tellg())); };
    lengths.fileHead(openvdb::OPENVDB_FILE_VERSION);
    readHeader(in);
    // OpenVDB's readers get these values from the stream.
    auto versions = std::make_shared<openvdb::io::StreamMetadata>();
    openvdb::io::setStreamMetadataPtr(in, versions, /*transfer=*/false);
    setFormatVersion(in);
    setLibraryVersion(in);
    setDataCompression(in);
    openvdb::MetaMap found;
    found.readMeta(in);
    if (!(found == expected))
      throw Error(ErrorCode::kDamaged, path, "metadata", "the file belongs to another brick; convert the source again");
    const std::int32_t count = readGridCount(in);
    for (std::int32_t i = 0; i < count; ++i) {
      openvdb::io::GridDescriptor descriptor;
      lengths.descriptor(position());
      const openvdb::GridBase::Ptr grid = descriptor.read(in);
      const std::uint64_t tree_at = lengths.gridHead(position());
      readGridCompression(in);
      openvdb::io::setGridBackgroundValuePtr(in, nullptr);
      readGridMetadata(*grid, in);
      openvdb::io::setGridClass(in, grid->getGridClass());
      grid->readTransform(in);
      grid->setName(openvdb::io::GridDescriptor::stripSuffix(descriptor.gridName()));
      take(*grid, [&] {
        lengths.treeMemory(tree_at,
                           {grid->valueType(), descriptor.saveFloatAsHalf(), openvdb::io::getDataCompression(in)});
        return !lengths.hasPackedNodes();
      });
    }
    openvdb::io::clearStreamMetadataPtr(in);
  }
};

// Reads the values of a grid's leaves in order. A tree of all leaves would take more memory than the brick and more
// time than all further work.
template <class Grid>
class LeafReader {
 public:
  using Leaf = typename Grid::TreeType::LeafNodeType;
  using Mask = typename Leaf::NodeMaskType;
  using Value = typename Grid::ValueType;

  LeafReader(const Grid& grid, MemoryReader& buffer, std::istream& in)
      : half_(grid.saveFloatAsHalf()),
        compression_(openvdb::io::getDataCompression(in)),
        packed_(compression_ == (openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK)),
        buffer_(buffer),
        in_(in),
        spare_(openvdb::PartialCreate(), grid.background()) {}

  /// Returns the frame of the next leaf's values, and advances, if the leaf has the form of the brick writer: the mask
  /// again, then only values of active voxels. Else returns an empty span, and the leaf must be read by `read`.
  std::span<const std::byte> frame(const Mask& active) {
    const std::span<const std::byte> out = packedBytes(active);
    if (out.empty() || !isLeafFrame(out, active.countOn() * storedBytes())) return {};
    buffer_.skip(kHead + out.size());
    // Assumes that the next leaf has about the length of this one.
    prefetchBytes(buffer_.rest(), kHead + out.size(), kHead + kPrefetchedBytes);
    return out;
  }
  /// True if `read` may read the next leaf, whose values have no frame: OpenVDB does not check its length.
  bool isSound(const Mask& active) const {
    if (!packed_) return (compression_ & (openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ZIP)) == 0;
    return lengthOf(active) == -static_cast<std::int64_t>(active.countOn() * storedBytes());
  }
  /// Calls f(leaf) after reading the next leaf's values into it. requires: `leaf` has its origin and mask.
  template <class F>
  void read(Leaf& leaf, F&& f) {
    leaf.swap(spare_);
    leaf.readBuffers(in_, half_);
    f(std::as_const(leaf));
    leaf.swap(spare_);
  }

 private:
  // Mask, kind of the inactive values, and length; the length is negative for uncompressed values.
  static constexpr std::size_t kHead = sizeof(Mask) + 1 + sizeof(std::int64_t);

  static constexpr std::size_t kPrefetchedBytes = 64;

  std::size_t storedBytes() const { return half_ ? sizeof(openvdb::math::half) : sizeof(Value); }
  // Returns 0 if the next leaf does not have the form of the brick writer.
  std::int64_t lengthOf(const Mask& active) const {
    const std::span<const std::byte> rest = buffer_.rest();
    if (!packed_ || rest.size() < kHead || std::memcmp(rest.data(), &active, sizeof(Mask)) != 0 ||
        rest[sizeof(Mask)] != std::byte{openvdb::io::NO_MASK_OR_INACTIVE_VALS})
      return 0;
    std::int64_t length;
    std::memcpy(&length, rest.data() + sizeof(Mask) + 1, sizeof length);
    return length;
  }
  std::span<const std::byte> packedBytes(const Mask& active) const {
    const std::int64_t length = lengthOf(active);
    const std::span<const std::byte> rest = buffer_.rest();
    if (length <= 0 || static_cast<std::uint64_t>(length) > rest.size() - kHead) return {};
    return rest.subspan(kHead, static_cast<std::size_t>(length));
  }

  const bool half_;
  const std::uint32_t compression_;
  const bool packed_;  // compressed as by the brick writer
  MemoryReader& buffer_;
  std::istream& in_;
  typename Leaf::Buffer spare_;
};

using NodesArePlain = std::function<bool()>;

template <class T>
class Decoder {
 public:
  Decoder(const BrickDesc& frame, const std::filesystem::path& path, MemoryReader& buffer, std::istream& in,
          BrickBlock& block)
      : core_(frame.core()),
        stored_(frame.stored()),
        edge_(static_cast<int>(frame.brick_size / kCellSize)),
        cells_(static_cast<std::size_t>(edge_) * edge_ * edge_),
        path_(path),
        buffer_(buffer),
        in_(in),
        block_(block) {}

  void take(openvdb::GridBase& base, const NodesArePlain& nodes_are_plain) {
    const auto known = std::find(kGrids.begin(), kGrids.end(), base.getName());
    if (known == kGrids.end()) fail(base.getName() + " is no grid of a brick");
    const auto which = static_cast<std::size_t>(known - kGrids.begin());
    if (std::exchange(taken_[which], true)) fail(base.getName() + " occurs twice");
    if (!takeAs<BrickGridFor<T>>(base, which, nodes_are_plain) && !takeAs<GridFor<T>>(base, which, nodes_are_plain))
      fail(base.getName() + " holds " + base.valueType());
  }

  // requires: all grids have been taken.
  void finish() {
    for (std::size_t i = 0; i < kGrids.size(); ++i) {
      if (!taken_[i]) fail("the grid " + std::string(kGrids[i]) + " is missing");
    }
    clampEdges(block_, stored_);
    block_.octree = MinMaxOctree(std::move(cells_), edge_);
  }

 private:
  static constexpr std::size_t kLeavesAhead = 2;
  static constexpr std::array<std::string_view, 4> kGrids = {kCoreGrid, kApronGrid, kCellMinGrid, kCellMaxGrid};

  template <class Grid>
  bool takeAs(openvdb::GridBase& base, std::size_t which, const NodesArePlain& nodes_are_plain) {
    auto* const grid = dynamic_cast<Grid*>(&base);
    if (grid == nullptr) return false;
    if (which < 2)
      takeVoxels(*grid, which == 0);
    else
      takeCells(*grid, which == 2, nodes_are_plain);
    return true;
  }

  template <class Grid>
  void takeVoxels(Grid& grid, bool core) {
    using Leaf = typename LeafReader<Grid>::Leaf;
    using Value = typename LeafReader<Grid>::Value;
    const VoxelBox& box = core ? core_ : stored_;
    const LeafLattice lattice(box);
    std::vector<PackedLeaves::Leaf> leaves;
    leaves.reserve(lattice.count());
    forEachLeafOfGrid(core_, stored_, core, [&](const VoxelCoord& origin, const VoxelBox& part) {
      leaves.push_back({coordOf(origin), maskOf(origin, part)});
    });
    skipTopology(grid, leaves);
    LeafReader<Grid> reader(grid, buffer_, in_);
    std::vector<std::span<const std::byte>> frames(lattice.count());
    for (const PackedLeaves::Leaf& place : leaves) {
      const VoxelCoord origin = voxelOf(place.origin);
      auto& frame = frames[lattice.indexOf(origin)];
      frame = reader.frame(place.active);
      if (!frame.empty()) continue;
      if (!reader.isSound(place.active)) fail(grid.getName() + " has values that cannot be decompressed");
      Leaf leaf(openvdb::PartialCreate(), place.origin);
      leaf.setValueMask(place.active);
      reader.read(leaf, [&](const Leaf& whole) {
        const VoxelBox part = intersection(leafAt(origin), box);
        copyLeaf(whole.buffer().data() + Leaf::coordToOffset(coordOf(part.lo)), {kLeaf * kLeaf, kLeaf}, part);
      });
    }
    alignas(64) UnpackedFor<Value, T> values[Leaf::SIZE];
    const bool halves = grid.saveFloatAsHalf();  // a search by name, too slow for each leaf
    forEachLeaf(box, [&](const VoxelBox& part) {
      const std::size_t at = lattice.indexOf(part.lo);
      const auto frame = frames[at];
      // Neighbouring leaves are far apart in the file.
      if (at + kLeavesAhead < frames.size()) {
        const auto& ahead = frames[at + kLeavesAhead];
        prefetchBytes(ahead, 0, ahead.size());
      }
      if (frame.empty()) return;
      const Extent3 n = part.extent();
      const auto count = static_cast<std::size_t>(n.count());
      unpackValues(grid, halves, frame, count, values);
      copyLeaf(values, {n.y * n.z, n.z}, part);
    });
  }

  template <class Grid, class To>
  void unpackValues(const Grid& grid, bool halves, std::span<const std::byte> frame, std::size_t count, To* out) const {
    using Stored = typename Grid::ValueType;
    if (!(halves ? unpackHalves(frame, count, out) : unpackLeaf<Stored>(frame, count, out)))
      fail(grid.getName() + " has values that cannot be decompressed");
  }

  template <class Value>
  static bool unpackHalves(std::span<const std::byte> frame, std::size_t count, Value* out) {
    alignas(64) std::uint16_t bits[kLeaf * kLeaf * kLeaf];
    if (!unpackLeaf<std::uint16_t>(frame, count, bits)) return false;
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<Value>(floatOfHalf(bits[i]));
    return true;
  }

  // Compares the topology of the file with the only topology that the brick's grid can have, and skips it.
  template <class Grid>
  void skipTopology(const Grid& grid, std::span<const PackedLeaves::Leaf> leaves) {
    const std::size_t bytes =
        matchTopology(buffer_.rest(), leaves, sizeof(typename Grid::ValueType), grid.saveFloatAsHalf());
    if (bytes == 0) fail(grid.getName() + " is not the tree of this brick's voxels");
    buffer_.skip(bytes);
  }

  template <class Grid>
  void takeCells(Grid& grid, bool least, const NodesArePlain& nodes_are_plain) {
    const auto set = [&](const VoxelCoord& cell, auto value) {
      const std::int64_t x = cell.x - core_.lo.x / kCellSize;
      const std::int64_t y = cell.y - core_.lo.y / kCellSize;
      const std::int64_t z = cell.z - core_.lo.z / kCellSize;
      if (!boxOf({edge_, edge_, edge_}).contains({x, y, z})) fail(grid.getName() + " has a cell outside the brick");
      ValueRange& range = cells_[static_cast<std::size_t>((z * edge_ + y) * edge_ + x)];
      (least ? range.lo : range.hi) = static_cast<double>(value);
    };
    if (takeAllCells(grid, set)) return;
    // OpenVDB would unpack values of nodes with Blosc, which trusts their lengths.
    if (!nodes_are_plain()) fail(grid.getName() + " has packed nodes");
    takeSomeCells(grid, set);
  }

  // Reads cells without building a tree. Returns false, and reads nothing, unless every cell of the core has a value.
  template <class Grid, class F>
  bool takeAllCells(const Grid& grid, F&& set) {
    using Leaf = typename LeafReader<Grid>::Leaf;
    using Value = typename LeafReader<Grid>::Value;
    VoxelBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = core_.lo[axis] / kCellSize;
      box.hi[axis] = (core_.hi[axis] - 1) / kCellSize + 1;
    }
    std::vector<PackedLeaves::Leaf> leaves;
    forEachLeafOfTree(box, [&](const VoxelCoord& origin, const VoxelBox& part) {
      leaves.push_back({coordOf(origin), maskOf(origin, part)});
    });
    const std::size_t bytes = matchTopology(buffer_.rest(), leaves, sizeof(Value), grid.saveFloatAsHalf());
    if (bytes == 0) return false;
    buffer_.skip(bytes);
    LeafReader<Grid> reader(grid, buffer_, in_);
    forEachLeafOfTree(box, [&](const VoxelCoord& origin, const VoxelBox& part) {
      const typename LeafReader<Grid>::Mask active = maskOf(origin, part);
      const std::span<const std::byte> frame = reader.frame(active);
      if (frame.empty()) {
        Leaf leaf(openvdb::PartialCreate(), coordOf(origin));
        leaf.setValueMask(active);
        readCells(grid, reader, leaf, set);
        return;
      }
      Value values[Leaf::SIZE];
      unpackValues(grid, grid.saveFloatAsHalf(), frame, static_cast<std::size_t>(part.count()), values);
      const Value* next = values;
      forCubes(part, 1, [&](const VoxelCoord& cell, const VoxelBox&) { set(cell, *next++); });
    });
    return true;
  }

  template <class Grid, class F>
  void takeSomeCells(Grid& grid, F&& set) {
    grid.readTopology(in_);
    LeafReader<Grid> reader(grid, buffer_, in_);
    for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) readCells(grid, reader, *leaf, set);
  }

  template <class Grid, class F>
  void readCells(const Grid& grid, LeafReader<Grid>& reader, typename LeafReader<Grid>::Leaf& leaf, F&& set) {
    using Reader = LeafReader<Grid>;
    if (const auto frame = reader.frame(leaf.valueMask()); !frame.empty()) {
      typename Reader::Value values[Reader::Leaf::SIZE];
      unpackValues(grid, grid.saveFloatAsHalf(), frame, leaf.valueMask().countOn(), values);
      const typename Reader::Value* next = values;
      for (auto cell = leaf.valueMask().beginOn(); cell; ++cell)
        set(voxelOf(leaf.offsetToGlobalCoord(cell.pos())), *next++);
      return;
    }
    if (!reader.isSound(leaf.valueMask())) fail(grid.getName() + " has values that cannot be decompressed");
    reader.read(leaf, [&](const auto& whole) {
      for (auto cell = whole.cbeginValueOn(); cell; ++cell) set(voxelOf(cell.getCoord()), *cell);
    });
  }

  // Copies a leaf from z fastest to x fastest.
  template <class Value>
  void copyLeaf(const Value* from, const std::array<std::int64_t, 2>& stride, const VoxelBox& part) {
    const Extent3 n = part.extent();
    T* const to = reinterpret_cast<T*>(block_.voxels.data()) + block_.offsetOf(part.lo);
    if (n == Extent3{kLeaf, kLeaf, kLeaf}) {
      const auto turn = [&](const T* values) {
        for (std::int64_t y = 0; y < kLeaf; ++y)
          transposeSquare(values + y * stride[1], stride[0], to + y * block_.strideY(), block_.strideZ());
      };
      if constexpr (std::is_same_v<Value, T>) return turn(from);
      alignas(64) T values[kLeaf * kLeaf * kLeaf];
      for (std::size_t i = 0; i < std::size(values); ++i) values[i] = static_cast<T>(from[i]);
      return turn(values);
    }
    for (std::int64_t z = 0; z < n.z; ++z) {
      for (std::int64_t y = 0; y < n.y; ++y) {
        T* const row = to + z * block_.strideZ() + y * block_.strideY();
        for (std::int64_t x = 0; x < n.x; ++x) row[x] = static_cast<T>(from[x * stride[0] + y * stride[1] + z]);
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
  MemoryReader& buffer_;
  std::istream& in_;
  BrickBlock& block_;
};

}  // namespace

BrickBlock decodeBrick(const BrickDesc& frame, std::span<const std::byte> file, const std::filesystem::path& path) {
  initializeOpenVdb();
  try {
    MemoryReader buffer(file);
    std::istream in(&buffer);
    in.exceptions(std::ios::failbit | std::ios::badbit);
    BrickBlock block = emptyBlock(frame);
    withVoxelType(frame.type, [&]<class T>(std::type_identity<T>) {
      Decoder<T> decoder(frame, path, buffer, in, block);
      ArchiveReader().read(file, in, metadataOf(frame), path,
                           [&](openvdb::GridBase& grid, const NodesArePlain& plain) { decoder.take(grid, plain); });
      decoder.finish();
    });
    block.supports = supportsOf(block);
    return block;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    rethrowRefusal();
    throw Error(ErrorCode::kDamaged, path, "OpenVDB", error.what());
  }
}

BrickBlock constantBrick(const BrickDesc& frame, double value) {
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

std::size_t blockBytes(const BrickDesc& frame) {
  const std::int64_t edge = frame.brick_size / kCellSize;
  const auto octree = static_cast<std::size_t>(edge * edge * edge * 8 / 7 + 1) * sizeof(ValueRange);
  return sizeof(BrickBlock) +
         static_cast<std::size_t>(dilated(frame.core(), frame.apron).count()) * sizeOf(frame.type) + octree +
         CellSupports::bytesFor(edge);
}

std::size_t decodeBytes(const BrickDesc& frame) {
  // Leaves and compressed values of one grid at a time, or the tree of its cells.
  const std::size_t leaves =
      LeafLattice(frame.stored()).count() * (sizeof(PackedLeaves::Leaf) + sizeof(std::span<const std::byte>));
  const std::size_t block = static_cast<std::size_t>(dilated(frame.core(), frame.apron).count()) * sizeOf(frame.type);
  // Leaves of some 100 bytes, and two nodes above them: 8 bytes per child and two masks.
  const std::int64_t edge = frame.brick_size / kCellSize;
  const auto across = static_cast<std::size_t>((edge + kLeaf - 1) / kLeaf);
  const std::size_t cell_tree = across * across * across * 160 + (std::size_t{300} << 10);
  // Leaves and the cell tree are freed before the supports of the cells are computed.
  const std::size_t supports =
      CellSupports::bytesFor(edge) + CellSupports::scratchBytes(frame.brick_size, frame.apron, frame.type);
  return std::max({leaves, cell_tree, supports}) + CellSupports::bytesFor(edge) + block + (std::size_t{1} << 18);
}

}  // namespace kiln
