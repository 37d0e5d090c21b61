// An OpenVDB grid as a dense box: the bounding box of its active voxels and tiles, with inactive values unchanged. Only
// the chosen grid is held in memory, in its sparse form. OpenVDB trusts the bytes of a file; vdb_bytes.h lists the
// checks made before, and unpacks all values. OpenVDB leaks the node under construction when it throws.
#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/tools/Dense.h>

#include <algorithm>
#include <glm/ext/matrix_transform.hpp>
#include <istream>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/refusal.h"
#include "grid/openvdb_glue.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/vdb/vdb_bytes.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

struct GridEntry {
  openvdb::io::GridDescriptor descriptor;
  openvdb::GridBase::Ptr grid;  // has no voxels until it is loaded
  std::string name() const { return openvdb::io::GridDescriptor::nameAsString(descriptor.uniqueName()); }
  const std::string& type() const { return descriptor.gridType(); }
};

// Replaces io::File on a checked stream: reads the directory of grids and loads the chosen grid at once.
class GridFile : public openvdb::io::Archive {
 public:
  /// throws: Error kBudget if the grids that must be read take more than `memory_bytes`.
  GridFile(const fs::path& path, std::uint64_t memory_bytes)
      : file_(path), memory_bytes_(memory_bytes), lengths_(vdbLengths(file_)), buffer_(file_), in_(&buffer_) {
    lengths_.fileHead(openvdb::OPENVDB_FILE_VERSION);
    in_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    readHeader(in_);
    openvdb::io::setStreamMetadataPtr(in_, stream_metadata_, /*transfer=*/false);
    openvdb::io::setVersion(in_, libraryVersion(), fileVersion());
    openvdb::io::setDataCompression(in_, compression());
    openvdb::MetaMap().readMeta(in_);
    const std::int32_t count = readGridCount(in_);
    for (std::int32_t i = 0; i < count; ++i) {
      GridEntry entry;
      lengths_.descriptor(position());
      entry.grid = entry.descriptor.read(in_);
      if (inputHasGridOffsets()) {
        entry.descriptor.seekToEnd(in_);
      } else {
        fill(entry);  // a file written to a pipe has no offsets: every grid must be read
      }
      entries_.push_back(std::move(entry));
    }
  }

  const std::vector<GridEntry>& entries() const { return entries_; }
  /// Memory of the grids read so far. unit: bytes.
  std::uint64_t heldBytes() const { return held_bytes_; }

  /// Reads the metadata of all grids, without voxels.
  void readMetadata() {
    if (!inputHasGridOffsets()) return;  // read already
    for (const GridEntry& entry : entries_) {
      entry.descriptor.seekToGrid(in_);
      walkHead();
      readGridCompression(in_);
      entry.grid->readMeta(in_);
    }
  }

  openvdb::GridBase::Ptr load(const GridEntry& entry) {
    if (!inputHasGridOffsets() && !entry.descriptor.isInstance()) return entry.grid;
    NamedGridMap named;
    for (const GridEntry& other : entries_) {
      const bool parent = other.descriptor.uniqueName() == entry.descriptor.instanceParentName();
      if (&other != &entry && !parent) continue;
      if (inputHasGridOffsets()) {
        other.descriptor.seekToGrid(in_);
        fill(other);
      }
      named[other.descriptor.uniqueName()] = other.grid;
    }
    connectInstance(entry.descriptor, named);
    return entry.grid;
  }

 private:
  std::uint64_t position() { return static_cast<std::uint64_t>(std::streamoff(in_.tellg())); }
  std::uint64_t walkHead() {
    const std::uint64_t tree_at = lengths_.gridHead(position());
    buffer_.setPacked(lengths_.packed());
    return tree_at;
  }
  void fill(const GridEntry& entry) {
    const std::uint64_t tree_at = walkHead();
    if (!entry.descriptor.isInstance()) {
      requireKnownMemory(entry);
      charge(entry, lengths_.treeMemory(tree_at,
                                        {entry.grid->valueType(), entry.descriptor.saveFloatAsHalf(), compression()}));
      buffer_.setPacked(lengths_.packed());
    }
    readGrid(entry.grid, entry.descriptor, in_);
  }

  // Grids of a file without offsets must all be read, even points and texts.
  void requireKnownMemory(const GridEntry& entry) const {
    if (VdbLengths::knowsMemoryOf(entry.grid->valueType())) return;
    throw Error(ErrorCode::kUnsupported, file_.path(), fmt::format("grid '{}' ({})", entry.name(), entry.type()),
                "must be read to reach the other grids of a file that was written to a pipe, and needs memory of "
                "unknown amount; write the file to a disk, or without this grid");
  }

  void charge(const GridEntry& entry, std::uint64_t bytes) {
    held_bytes_ += bytes;
    if (held_bytes_ <= memory_bytes_) return requireMemory(bytes);
    throw Error(
        ErrorCode::kBudget, file_.path(), "--memory",
        fmt::format("{} is too little: grid '{}' is read whole, which takes {}, and the buffers of a conversion "
                    "come on top",
                    formatBytes(memory_bytes_), entry.name(), formatBytes(held_bytes_)));
  }

  File file_;
  const std::uint64_t memory_bytes_;
  std::uint64_t held_bytes_ = 0;
  VdbLengths lengths_;
  VdbBytes buffer_;
  // The stream stores the address of this pointer, so the pointer must outlive the stream.
  std::shared_ptr<openvdb::io::StreamMetadata> stream_metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
  std::istream in_;
  std::vector<GridEntry> entries_;
};

bool isWide(const openvdb::GridBase& grid) { return grid.isType<openvdb::Int64Grid>(); }

// True if the grid has one number per voxel.
bool scalarOf(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>() || grid.isType<openvdb::Int32Grid>() ||
         isWide(grid);
}

std::string reasonAgainst(const openvdb::GridBase& grid) {
  const std::string type = grid.valueType();
  if (type.starts_with("ptdata") || type.starts_with("ptidx")) return "holds points, not a value a voxel";
  if (type.starts_with("vec")) return "holds vectors, not one value a voxel";
  if (type == "bool" || type == "mask") return "holds a mask without values";
  if (type == "string") return "holds text";
  return "has a type that Kiln does not read";
}

[[noreturn]] void refuse(const fs::path& path, const GridEntry& entry, const std::string& why) {
  throw Error(ErrorCode::kUnsupported, path, fmt::format("grid '{}' ({})", entry.name(), entry.type()), why);
}

std::string listOf(const std::vector<GridEntry>& entries) {
  std::string out;
  for (const GridEntry& entry : entries)
    out += fmt::format("{}'{}' ({})", out.empty() ? "" : ", ", entry.name(), entry.type());
  return out.empty() ? "none" : out;
}

// Names the grids that could have been read instead of the chosen grid, as a note; empty if there are none.
std::string otherGridsText(const std::vector<GridEntry>& entries, const GridEntry& chosen) {
  std::vector<GridEntry> others;
  for (const GridEntry& entry : entries) {
    if (&entry != &chosen && scalarOf(*entry.grid)) others.push_back(entry);
  }
  if (others.empty()) return {};
  return fmt::format("grid '{}' is read, and not {}; --grid NAME chooses", chosen.name(), listOf(others));
}

const GridEntry& chooseGrid(const fs::path& path, const std::vector<GridEntry>& entries, const SourceOptions& options) {
  if (options.grid_name) {
    const auto named = [&](const GridEntry& entry) { return entry.name() == *options.grid_name; };
    const auto found = std::find_if(entries.begin(), entries.end(), named);
    if (found == entries.end()) {
      throw Error(ErrorCode::kUsage, path, "",
                  fmt::format("has no grid '{}'; it has {}", *options.grid_name, listOf(entries)));
    }
    return *found;
  }
  std::vector<const GridEntry*> scalar;
  // Grids of 64-bit integers are often identifiers beside the volume, so they are tried last.
  for (const bool wide : {false, true}) {
    for (const GridEntry& entry : entries) {
      if (scalarOf(*entry.grid) && isWide(*entry.grid) == wide) scalar.push_back(&entry);
    }
    if (!scalar.empty()) break;
  }
  if (scalar.size() == 1) return *scalar.front();
  for (const GridEntry* entry : scalar) {
    if (entry->name() == "density") return *entry;
  }
  if (entries.size() == 1) return entries.front();  // refused later, with the specific reason
  if (scalar.empty()) {
    throw Error(ErrorCode::kUnsupported, path, "",
                fmt::format("has no grid that Kiln reads; it has {}", listOf(entries)));
  }
  throw Error(ErrorCode::kUsage, path, "",
              fmt::format("has several grids; choose one with --grid NAME; it has {}", listOf(entries)));
}

// OpenVDB's tree loops count in 32 bits up to one beyond the end of a root's child: the outermost children of 4096
// voxels would overflow.
constexpr int kFirstIndex = std::numeric_limits<int>::min() + openvdb::FloatTree::RootNodeType::ChildNodeType::DIM;
constexpr int kLastIndex = std::numeric_limits<int>::max() - openvdb::FloatTree::RootNodeType::ChildNodeType::DIM;

VoxelBox activeBox(const openvdb::GridBase& grid, const fs::path& path, const GridEntry& entry) {
  const std::string place = fmt::format("grid '{}'", entry.name());
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  if (grid.empty() || box.empty())
    throw Error(ErrorCode::kFormat, path, place, "has no active voxel: there is nothing to read");
  for (int axis = 0; axis < 3; ++axis) {
    const int lo = box.min()[axis], hi = box.max()[axis];
    if (lo < kFirstIndex || hi > kLastIndex)
      throw Error(ErrorCode::kUnsupported, path, place,
                  fmt::format("has active voxels from {} to {} along axis {}; {} to {} are read: move the grid", lo, hi,
                              axis, kFirstIndex, kLastIndex));
  }
  return {{box.min().x(), box.min().y(), box.min().z()},
          {std::int64_t{box.max().x()} + 1, std::int64_t{box.max().y()} + 1, std::int64_t{box.max().z()} + 1}};
}

SourceInfo infoOf(const openvdb::GridBase& grid, VoxelType type, const fs::path& path, const GridEntry& entry) {
  if (!grid.transform().isLinear()) {
    refuse(path, entry, fmt::format("has a transform that is not affine ({}, a frustum)", grid.transform().mapType()));
  }
  const VoxelBox box = activeBox(grid, path, entry);
  SourceInfo info;
  info.format = "OpenVDB";
  info.files = {path};
  info.type = type;
  info.volume_class = grid.getGridClass() == openvdb::GRID_LEVEL_SET ? VolumeClass::kLevelSet : VolumeClass::kFog;
  info.vdb = VdbOrigin{entry.name(), box.lo, affineOf(grid.transform())};
  info.geometry.dims = box.extent();
  const glm::dvec3 origin(static_cast<double>(box.lo.x), static_cast<double>(box.lo.y), static_cast<double>(box.lo.z));
  info.geometry.world_from_index = glm::translate(info.vdb->world_from_grid, origin);
  requireInvertible(info.vdb->world_from_grid, path.string());
  requireInvertible(info.geometry.world_from_index, path.string());
  checkedBytes(info.geometry.dims, info.type, path);
  return info;
}

// `T` holds all values of the grid.
template <class Grid, class T>
class VdbSource : public VolumeSource {
 public:
  VdbSource(SourceInfo info, typename Grid::ConstPtr grid, std::uint64_t held_bytes)
      : info_(std::move(info)), grid_(std::move(grid)), held_bytes_(held_bytes) {
    info_.background = static_cast<double>(grid_->background());
  }

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  std::uint64_t heldBytes() const override { return held_bytes_; }

  void read(const VoxelBox& box, std::span<std::byte> out) override {
    const VoxelCoord& at = info_.vdb->index_origin;
    if (box.empty()) return;
    const openvdb::CoordBBox voxels(coordOf({box.lo.x + at.x, box.lo.y + at.y, box.lo.z + at.z}),
                                    coordOf({box.hi.x + at.x - 1, box.hi.y + at.y - 1, box.hi.z + at.z - 1}));
    openvdb::tools::Dense<T, openvdb::tools::LayoutXYZ> dense(voxels, reinterpret_cast<T*>(out.data()));
    // Serial: OpenVDB splits a box among threads at half the sum of its ends, which overflows beyond 2^30; and a
    // conversion reads from all threads already.
    openvdb::tools::copyToDense(*grid_, dense, /*serial=*/true);
  }

 private:
  SourceInfo info_;
  typename Grid::ConstPtr grid_;
  std::uint64_t held_bytes_;
};

// Returns the 32-bit type that holds every value of a 64-bit grid, inactive values and the background included.
VoxelType narrowTypeOf(const openvdb::Int64Grid& grid, const fs::path& path, const GridEntry& entry) {
  std::int64_t lo = grid.background(), hi = lo;
  for (auto value = grid.cbeginValueAll(); value; ++value) {
    lo = std::min<std::int64_t>(lo, *value);
    hi = std::max<std::int64_t>(hi, *value);
  }
  if (lo >= 0 && hi <= std::numeric_limits<std::uint32_t>::max()) return VoxelType::u32;
  if (lo >= std::numeric_limits<std::int32_t>::min() && hi <= std::numeric_limits<std::int32_t>::max())
    return VoxelType::i32;
  refuse(path, entry, fmt::format("holds 64-bit integers from {} to {}; values that fit in 32 bits are read", lo, hi));
}

std::unique_ptr<VolumeSource> openChecked(const fs::path& path, const SourceOptions& options) {
  if (options.spacing) refuseSpacing(path);
  initializeOpenVdb();
  GridFile file(path, options.memory_bytes);
  const GridEntry& entry = chooseGrid(path, file.entries(), options);
  if (!scalarOf(*entry.grid)) refuse(path, entry, reasonAgainst(*entry.grid));
  const openvdb::GridBase::Ptr grid = file.load(entry);
  const auto open = [&]<class Grid, class T>(const std::shared_ptr<Grid>& typed, VoxelType type,
                                             std::type_identity<T>) -> std::unique_ptr<VolumeSource> {
    SourceInfo info = infoOf(*grid, type, path, entry);
    if (const std::string note = otherGridsText(file.entries(), entry); !options.grid_name && !note.empty())
      info.notes.push_back(note);
    return std::make_unique<VdbSource<Grid, T>>(std::move(info), typed, file.heldBytes());
  };
  if (const auto f32 = openvdb::gridPtrCast<openvdb::FloatGrid>(grid))
    return open(f32, VoxelType::f32, std::type_identity<float>());
  if (const auto f64 = openvdb::gridPtrCast<openvdb::DoubleGrid>(grid))
    return open(f64, VoxelType::f64, std::type_identity<double>());
  if (const auto i32 = openvdb::gridPtrCast<openvdb::Int32Grid>(grid))
    return open(i32, VoxelType::i32, std::type_identity<std::int32_t>());
  const auto wide = openvdb::gridPtrCast<openvdb::Int64Grid>(grid);
  const VoxelType narrow = narrowTypeOf(*wide, path, entry);
  if (narrow == VoxelType::u32) return open(wide, narrow, std::type_identity<std::uint32_t>());
  return open(wide, narrow, std::type_identity<std::int32_t>());
}

}  // namespace

namespace {

// Calls open(), and turns OpenVDB's exceptions to Error.
template <class Open>
auto withErrorsOf(const fs::path& input, const Open& open) {
  try {
    return open();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    rethrowRefusal();
    throw Error(ErrorCode::kFormat, input, "OpenVDB",
                std::string(error.what()) + "; the file is damaged, or newer than this OpenVDB reads");
  }
}

// The extent of the active voxels, which most writers put into the metadata.
std::optional<Extent3> extentOf(const openvdb::GridBase& grid) {
  const auto lo = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN),
             hi = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  if (!lo || !hi) return std::nullopt;
  const auto edge = [&](int axis) { return std::int64_t{hi->value()[axis]} - lo->value()[axis] + 1; };
  const Extent3 out = {edge(0), edge(1), edge(2)};
  return std::min({out.x, out.y, out.z}) > 0 ? std::optional(out) : std::nullopt;
}

ListedVolume listed(const GridEntry& entry, bool one_of_several) {
  const openvdb::GridBase& grid = *entry.grid;
  ListedVolume out;
  out.name = entry.name();
  out.kind = grid.getGridClass() == openvdb::GRID_LEVEL_SET ? "level set" : grid.valueType();
  out.dims = extentOf(grid);
  if (grid.isType<openvdb::FloatGrid>()) out.type = VoxelType::f32;
  if (grid.isType<openvdb::DoubleGrid>()) out.type = VoxelType::f64;
  if (grid.isType<openvdb::Int32Grid>()) out.type = VoxelType::i32;
  if (!scalarOf(grid))
    out.refusal = reasonAgainst(grid);
  else if (one_of_several)
    out.option = "--grid " + out.name;
  return out;
}

}  // namespace

std::vector<ListedVolume> listVdb(const fs::path& input, const SourceOptions& options) {
  return withErrorsOf(input, [&] {
    initializeOpenVdb();
    GridFile file(input, options.memory_bytes);
    file.readMetadata();
    std::vector<ListedVolume> out;
    for (const GridEntry& entry : file.entries()) out.push_back(listed(entry, file.entries().size() > 1));
    return out;
  });
}

std::unique_ptr<VolumeSource> openVdb(const fs::path& input, const SourceOptions& options) {
  return withErrorsOf(input, [&] { return openChecked(input, options); });
}

}  // namespace kiln
