// Voxels to a brick file. Grids are filled leaf by leaf, so that exactly the voxels of core and apron are active
// whatever their value, and the bytes depend on the voxels alone.
#include <fmt/format.h>
#include <openvdb/io/Archive.h>

#include <algorithm>
#include <cstring>
#include <ostream>
#include <streambuf>

#include "base/hash.h"
#include "store/brick_file.h"

namespace kiln {
namespace {

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
    typename Grid::Ptr grid = makeGrid(name, transformOf(frame_.geometry.world_from_index), half_);
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
    // On coarser levels cells hold values of voxels below, which need not survive where the brick's own do.
    const bool half = half_ && std::all_of(cells.begin(), cells.end(), [](const ValueRange& cell) {
                        return cell.empty() ||
                               (survivesHalf(static_cast<float>(cell.lo)) && survivesHalf(static_cast<float>(cell.hi)));
                      });
    typename Grid::Ptr grid = makeGrid(name, transformOf(frame_.geometry.world_from_index * index_from_cell), half);
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

  typename Grid::Ptr makeGrid(const char* name, openvdb::math::Transform::Ptr transform, bool half) const {
    typename Grid::Ptr grid = Grid::create(Value(0));
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
    const openvdb::GridCPtrVec grids = {encoder.voxelGrid(kCoreGrid, true), encoder.voxelGrid(kApronGrid, false),
                                        encoder.cellGrid(kCellMinGrid, cells, true),
                                        encoder.cellGrid(kCellMaxGrid, cells, false)};
    MemoryWriter buffer;
    std::ostream out(&buffer);
    SeekableArchive().writeTo(out, grids, metadataOf(frame));
    std::vector<std::byte> file = buffer.take();
    stampUuid(file);
    return file;
  });
}

std::string containerVersion() { return std::string("OpenVDB ") + openvdb::getLibraryVersionString(); }

}  // namespace kiln
