// An OpenVDB grid as a dense box: the bounding box of its active voxels and tiles, inactive values included as they
// are. The grid is held in memory in its sparse form; only the one that is read. OpenVDB trusts the bytes of a file;
// vdb_bytes.h says what is checked before it sees them. OpenVDB also loses the node that it was reading when it throws.
#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/tools/Dense.h>

#include <algorithm>
#include <glm/ext/matrix_transform.hpp>
#include <istream>
#include <new>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "grid/openvdb_glue.h"
#include "ingest/formats.h"
#include "ingest/linear_source.h"
#include "ingest/vdb_bytes.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

struct GridEntry {
  openvdb::io::GridDescriptor descriptor;
  openvdb::GridBase::Ptr grid;  // empty of voxels until it is loaded
  std::string name() const { return openvdb::io::GridDescriptor::nameAsString(descriptor.uniqueName()); }
  const std::string& type() const { return descriptor.gridType(); }
};

// What io::File does, on our stream: a directory of grids, of which one is read. Nothing is loaded later.
class GridFile : public openvdb::io::Archive {
 public:
  explicit GridFile(const fs::path& path) : file_(path), buffer_(file_), in_(&buffer_) {
    requireVdbLengths(file_);
    in_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    readHeader(in_);
    openvdb::io::setStreamMetadataPtr(in_, stream_metadata_, /*transfer=*/false);
    openvdb::io::setVersion(in_, libraryVersion(), fileVersion());
    openvdb::io::setDataCompression(in_, compression());
    openvdb::MetaMap().readMeta(in_);
    const std::int32_t count = readGridCount(in_);
    for (std::int32_t i = 0; i < count; ++i) {
      GridEntry entry;
      entry.grid = entry.descriptor.read(in_);
      if (inputHasGridOffsets()) {
        entry.descriptor.seekToEnd(in_);
      } else {
        fill(entry);  // a file written to a pipe knows no places: all of it must be read
      }
      entries_.push_back(std::move(entry));
    }
  }

  const std::vector<GridEntry>& entries() const { return entries_; }

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
  void fill(const GridEntry& entry) { readGrid(entry.grid, entry.descriptor, in_); }

  File file_;
  VdbBytes buffer_;
  // The stream keeps the address of this pointer, so it must live as long.
  std::shared_ptr<openvdb::io::StreamMetadata> stream_metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
  std::istream in_;
  std::vector<GridEntry> entries_;
};

std::optional<VoxelType> typeOf(const openvdb::GridBase& grid) {
  if (grid.isType<openvdb::FloatGrid>()) return VoxelType::f32;
  if (grid.isType<openvdb::DoubleGrid>()) return VoxelType::f64;
  if (grid.isType<openvdb::Int32Grid>()) return VoxelType::i32;
  return std::nullopt;
}

std::string reasonAgainst(const openvdb::GridBase& grid) {
  const std::string type = grid.valueType();
  if (type.starts_with("ptdata") || type.starts_with("ptidx")) return "holds points, not a value a voxel";
  if (type.starts_with("vec")) return "holds vectors, not one value a voxel";
  if (type == "bool" || type == "mask") return "holds a mask without values";
  if (type == "int64") return "holds 64-bit integers, which Kiln does not read";
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
  for (const GridEntry& entry : entries) {
    if (typeOf(*entry.grid)) scalar.push_back(&entry);
  }
  if (scalar.size() == 1) return *scalar.front();
  for (const GridEntry* entry : scalar) {
    if (entry->name() == "density") return *entry;
  }
  if (entries.size() == 1) return entries.front();  // its own reason against it follows
  if (scalar.empty()) {
    throw Error(ErrorCode::kUnsupported, path, "",
                fmt::format("has no grid that Kiln reads; it has {}", listOf(entries)));
  }
  throw Error(ErrorCode::kUsage, path, "",
              fmt::format("has several grids; choose one with --grid NAME; it has {}", listOf(entries)));
}

VoxelBox activeBox(const openvdb::GridBase& grid, const fs::path& path, const GridEntry& entry) {
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  if (grid.empty() || box.empty()) {
    throw Error(ErrorCode::kFormat, path, fmt::format("grid '{}'", entry.name()),
                "has no active voxel: there is nothing to read");
  }
  return {{box.min().x(), box.min().y(), box.min().z()},
          {std::int64_t{box.max().x()} + 1, std::int64_t{box.max().y()} + 1, std::int64_t{box.max().z()} + 1}};
}

SourceInfo infoOf(const openvdb::GridBase& grid, const fs::path& path, const GridEntry& entry) {
  if (!grid.transform().isLinear()) {
    refuse(path, entry, fmt::format("has a transform that is not affine ({}, a frustum)", grid.transform().mapType()));
  }
  const VoxelBox box = activeBox(grid, path, entry);
  SourceInfo info;
  info.format = "OpenVDB";
  info.files = {path};
  info.type = *typeOf(grid);
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

template <class Grid>
class VdbSource : public VolumeSource {
 public:
  using T = typename Grid::ValueType;

  VdbSource(SourceInfo info, typename Grid::ConstPtr grid) : info_(std::move(info)), grid_(std::move(grid)) {
    info_.background = static_cast<double>(grid_->background());
  }

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }

  void read(const VoxelBox& box, std::span<std::byte> out) override {
    const VoxelCoord& at = info_.vdb->index_origin;
    if (box.empty()) return;
    const openvdb::CoordBBox voxels(coordOf({box.lo.x + at.x, box.lo.y + at.y, box.lo.z + at.z}),
                                    coordOf({box.hi.x + at.x - 1, box.hi.y + at.y - 1, box.hi.z + at.z - 1}));
    openvdb::tools::Dense<T, openvdb::tools::LayoutXYZ> dense(voxels, reinterpret_cast<T*>(out.data()));
    openvdb::tools::copyToDense(*grid_, dense);
  }

 private:
  SourceInfo info_;
  typename Grid::ConstPtr grid_;
};

std::unique_ptr<VolumeSource> openChecked(const fs::path& path, const SourceOptions& options) {
  if (options.spacing)
    throw Error(ErrorCode::kUsage, path, "", "says where its voxels are; --spacing is for files that do not");
  initializeOpenVdb();
  GridFile file(path);
  const GridEntry& entry = chooseGrid(path, file.entries(), options);
  const std::optional<VoxelType> type = typeOf(*entry.grid);
  if (!type) refuse(path, entry, reasonAgainst(*entry.grid));
  const openvdb::GridBase::Ptr grid = file.load(entry);
  SourceInfo info = infoOf(*grid, path, entry);
  switch (*type) {
    case VoxelType::f32:
      return std::make_unique<VdbSource<openvdb::FloatGrid>>(std::move(info),
                                                             openvdb::gridPtrCast<openvdb::FloatGrid>(grid));
    case VoxelType::f64:
      return std::make_unique<VdbSource<openvdb::DoubleGrid>>(std::move(info),
                                                              openvdb::gridPtrCast<openvdb::DoubleGrid>(grid));
    default:
      return std::make_unique<VdbSource<openvdb::Int32Grid>>(std::move(info),
                                                             openvdb::gridPtrCast<openvdb::Int32Grid>(grid));
  }
}

}  // namespace

std::unique_ptr<VolumeSource> openVdb(const fs::path& input, const SourceOptions& options) {
  try {
    return openChecked(input, options);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kFormat, input, "OpenVDB",
                "asks for more memory than there is: the file is damaged, or its grid too large to be held");
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kFormat, input, "OpenVDB",
                std::string(error.what()) + "; the file is damaged, or newer than this OpenVDB reads");
  }
}

}  // namespace kiln
