// A brick as an OpenVDB file (FORMAT.md, brick files). Grids are filled leaf by leaf, so that exactly the voxels of
// core and apron are active whatever their value, and the bytes depend on the voxels alone.
#include "store/brick_codec.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/Stream.h>

#include <cstring>
#include <istream>
#include <ostream>
#include <streambuf>

#include "base/error.h"
#include "base/hash.h"
#include "grid/openvdb_glue.h"
#include "store/manifest.h"

namespace kiln {
namespace {

constexpr std::int64_t kLeaf = 8;
constexpr std::size_t kUuidAt = 21;
constexpr std::size_t kUuidLength = 36;

// io::Stream writes no grid offsets, io::File only to a named file: this writes what io::File does, to memory.
class SeekableArchive : public openvdb::io::Archive {
 public:
  void writeTo(std::ostream& out, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) {
    setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    setGridStatsMetadataEnabled(false);
    Archive::write(out, grids, /*seekable=*/true, metadata);
  }
};

// A growing buffer that can be written at any place, as an archive with offsets needs.
class MemoryWriter : public std::streambuf {
 public:
  std::vector<std::byte> take() { return std::move(data_); }

 protected:
  std::streamsize xsputn(const char* from, std::streamsize count) override {
    const std::size_t end = at_ + static_cast<std::size_t>(count);
    if (end > data_.size()) {
      if (end > data_.capacity()) data_.reserve(std::max(end, data_.capacity() * 2));
      data_.resize(end);
    }
    std::memcpy(data_.data() + at_, from, static_cast<std::size_t>(count));
    at_ = end;
    return count;
  }
  int_type overflow(int_type c) override {
    const char byte = traits_type::to_char_type(c);
    return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
  }
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const auto base = from == std::ios_base::beg ? 0 : from == std::ios_base::cur ? at_ : data_.size();
    at_ = static_cast<std::size_t>(static_cast<off_type>(base) + offset);
    return static_cast<pos_type>(static_cast<off_type>(at_));
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode) override {
    at_ = static_cast<std::size_t>(static_cast<off_type>(position));
    return position;
  }

 private:
  std::vector<std::byte> data_;
  std::size_t at_ = 0;
};

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

std::int64_t leafBelow(std::int64_t n) { return n & ~(kLeaf - 1); }

bool inside(const VoxelBox& inner, const VoxelBox& outer) { return intersection(inner, outer) == inner; }

// Calls leaf(origin, part) for each 8³ leaf that has voxels in `box`; `part` is what of it lies in the box.
template <class F>
void forEachLeaf(const VoxelBox& box, F&& leaf) {
  for (std::int64_t z = leafBelow(box.lo.z); z < box.hi.z; z += kLeaf) {
    for (std::int64_t y = leafBelow(box.lo.y); y < box.hi.y; y += kLeaf) {
      for (std::int64_t x = leafBelow(box.lo.x); x < box.hi.x; x += kLeaf) {
        leaf(VoxelCoord{x, y, z}, intersection({{x, y, z}, {x + kLeaf, y + kLeaf, z + kLeaf}}, box));
      }
    }
  }
}

template <class T>
class Encoder {
 public:
  using Grid = GridFor<T>;
  using Value = typename Grid::ValueType;

  Encoder(const BrickFrame& frame, std::span<const std::byte> voxels)
      : frame_(frame),
        core_(frame.core()),
        box_(frame.stored()),
        size_(box_.extent()),
        voxels_(reinterpret_cast<const T*>(voxels.data())),
        half_(fitsHalf()) {}

  openvdb::GridBase::Ptr voxelGrid(const char* name, bool core) const {
    typename Grid::Ptr grid = makeGrid(name, transformOf(frame_.geometry.world_from_index));
    forEachLeaf(core ? core_ : box_, [&](const VoxelCoord& origin, const VoxelBox& part) {
      if (!core && inside(part, core_)) return;
      auto* leaf = grid->tree().touchLeaf(coordOf(origin));
      for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
        for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
          for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
            if (!core && core_.contains({x, y, z})) continue;
            leaf->setValueOn(openvdb::Index(((x - origin.x) << 6) | ((y - origin.y) << 3) | (z - origin.z)),
                             valueAt(x, y, z));
          }
        }
      }
    });
    return grid;
  }

  openvdb::GridBase::Ptr cellGrid(const char* name, std::span<const ValueRange> cells, bool least) const {
    // Cell c covers voxels [8c, 8c+8): its centre is at voxel 8c + 3.5.
    const double s = static_cast<double>(kCellSize);
    glm::dmat4 index_from_cell(s);
    index_from_cell[3] = glm::dvec4(glm::dvec3((s - 1) / 2), 1.0);
    typename Grid::Ptr grid = makeGrid(name, transformOf(frame_.geometry.world_from_index * index_from_cell));
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
    return grid;
  }

 private:
  Value valueAt(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<Value>(voxels_[((z - box_.lo.z) * size_.y + (y - box_.lo.y)) * size_.x + (x - box_.lo.x)]);
  }

  bool fitsHalf() const {
    if constexpr (std::is_same_v<T, std::uint8_t> || std::is_same_v<T, std::int8_t>) {
      return true;
    } else if constexpr (std::is_same_v<Grid, openvdb::FloatGrid>) {
      for (std::int64_t i = 0; i < size_.count(); ++i) {
        if (!survivesHalf(static_cast<float>(voxels_[i]))) return false;
      }
      return true;
    } else {
      return false;
    }
  }

  typename Grid::Ptr makeGrid(const char* name, openvdb::math::Transform::Ptr transform) const {
    typename Grid::Ptr grid = Grid::create(Value(0));
    grid->setName(name);
    grid->setTransform(std::move(transform));
    grid->setSaveFloatAsHalf(half_);
    return grid;
  }

  const BrickFrame& frame_;
  VoxelBox core_, box_;
  Extent3 size_;
  const T* voxels_;
  bool half_;
};

openvdb::MetaMap metadataOf(const BrickFrame& frame) {
  openvdb::MetaMap out;
  const BrickCoord& brick = frame.key.brick;
  out.insertMeta("kiln_format", openvdb::Int32Metadata(kFormatVersion));
  out.insertMeta("kiln_level", openvdb::Int32Metadata(frame.key.level));
  out.insertMeta("kiln_brick", openvdb::Vec3IMetadata(openvdb::Vec3i(brick.x, brick.y, brick.z)));
  out.insertMeta("kiln_type", openvdb::StringMetadata(std::string(nameOf(frame.type))));
  return out;
}

// OpenVDB's random UUID becomes the content's own.
void stampUuid(std::vector<std::byte>& file) {
  std::memset(file.data() + kUuidAt, '0', kUuidLength);
  const std::string hex = toHex(hashOf(file));
  const std::string uuid = fmt::format("{}-{}-{}-{}-{}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                                       hex.substr(16, 4), hex.substr(20, 12));
  std::memcpy(file.data() + kUuidAt, uuid.data(), kUuidLength);
}

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
  decoder.take(*gridNamed(grids, "density", path), true);
  decoder.take(*gridNamed(grids, "apron", path), false);
  decoder.clampEdges();
  const int edge = static_cast<int>(frame.brick_size / kCellSize);
  std::vector<ValueRange> cells(static_cast<std::size_t>(edge) * edge * edge);
  decoder.takeCells(*gridNamed(grids, "cell_min", path), cells, edge, true);
  decoder.takeCells(*gridNamed(grids, "cell_max", path), cells, edge, false);
  block.octree = MinMaxOctree(std::move(cells), edge);
  return block;
}

}  // namespace

std::vector<std::byte> encodeBrick(const BrickFrame& frame, std::span<const std::byte> voxels) {
  initializeOpenVdb();
  return withVoxelType(frame.type, [&]<class T>(std::type_identity<T>) {
    const Encoder<T> encoder(frame, voxels);
    const int edge = static_cast<int>(frame.brick_size / kCellSize);
    const std::vector<ValueRange> cells = cellRanges(voxels, frame.type, frame.stored(), frame.core(), edge);
    const openvdb::GridCPtrVec grids = {encoder.voxelGrid("density", true), encoder.voxelGrid("apron", false),
                                        encoder.cellGrid("cell_min", cells, true),
                                        encoder.cellGrid("cell_max", cells, false)};
    MemoryWriter buffer;
    std::ostream out(&buffer);
    SeekableArchive().writeTo(out, grids, metadataOf(frame));
    std::vector<std::byte> file = buffer.take();
    stampUuid(file);
    return file;
  });
}

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

std::string containerVersion() { return std::string("OpenVDB ") + openvdb::getLibraryVersionString(); }

}  // namespace kiln
