#include "support/files/vdb_files.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/PointIndexGrid.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "grid/openvdb_glue.h"

// OpenVDB 10 leaks the current node if the file ends inside it (RootNode and InternalNode::readTopology, a plain new):
// a leak for each damaged file, inside OpenVDB. The library's stack frames have no function names, so the suppression
// names the library.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libopenvdb"; }

namespace kiln::test {
namespace {

template <class Grid>
typename Grid::Ptr fog() {
  using Value = typename Grid::ValueType;
  auto grid = newGrid<Grid>(static_cast<Value>(kVdbBackground));
  auto accessor = grid->getAccessor();
  int n = 0;
  for (std::int64_t z = 0; z < kVdbDims.z; ++z) {
    for (std::int64_t y = 0; y < kVdbDims.y; ++y) {
      for (std::int64_t x = 0; x < kVdbDims.x; ++x, ++n) {
        const VoxelCoord v = {kVdbOrigin.x + x, kVdbOrigin.y + y, kVdbOrigin.z + z};
        const auto value = static_cast<Value>(vdbValue(v));
        if (n % 7 == 3)
          accessor.setValueOff(coordOf(v), value);
        else
          accessor.setValueOn(coordOf(v), value);
      }
    }
  }
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

openvdb::FloatGrid::Ptr tiles() {
  auto grid = newGrid<openvdb::FloatGrid>(0.5f);
  grid->tree().addTile(1, openvdb::Coord(-16, 0, 8), 2.25f, true);  // a single 8³ tile
  grid->fill(openvdb::CoordBBox(4, 3, 2, 23, 22, 21), -7, true);    // tiles and leaves
  grid->tree().setValueOn(openvdb::Coord(30, -5, 1), 9);
  return grid;
}

template <class Grid, class Value>
openvdb::GridBase::Ptr single(const Value& value) {
  auto grid = newGrid<Grid>(openvdb::zeroVal<typename Grid::ValueType>());
  grid->tree().setValueOn(openvdb::Coord(1, 2, 3), value);
  return grid;
}

// Empty: the test needs only a type that is no volume.
template <class Grid>
openvdb::GridBase::Ptr points() {
  return openvdb::GridBase::createGrid(Grid::gridType());
}

openvdb::GridBase::Ptr voxelsOf(const std::vector<std::pair<openvdb::Coord, std::int64_t>>& values) {
  auto grid = newGrid<openvdb::Int64Grid>(0);
  for (const auto& [at, value] : values) grid->tree().setValueOn(at, value);
  return grid;
}

openvdb::FloatGrid::Ptr twoVoxels(const VoxelCoord& at) {
  auto grid = newGrid<openvdb::FloatGrid>(0);
  grid->tree().setValueOn(coordOf(at), 1);
  grid->tree().setValueOn(coordOf({at.x + 5, at.y + 5, at.z + 5}), 2);
  return grid;
}

openvdb::GridBase::Ptr gridOf(const VdbSpec& spec) {
  switch (spec.kind) {
    case VdbKind::kWide:
      return voxelsOf({{{0, 0, 0}, -1}, {{1, 0, 0}, 4294967295}});
    case VdbKind::kUnsigned:
      return voxelsOf({{{0, 0, 0}, 4294967295}, {{1, 0, 0}, 7}});
    case VdbKind::kFar:
      return twoVoxels(spec.at);
    case VdbKind::kFloat:
    case VdbKind::kHalf:
    case VdbKind::kFrustum:
      return fog<openvdb::FloatGrid>();
    case VdbKind::kDouble:
      return fog<openvdb::DoubleGrid>();
    case VdbKind::kInt32:
      return fog<openvdb::Int32Grid>();
    case VdbKind::kInt64:
      return fog<openvdb::Int64Grid>();
    case VdbKind::kTiles:
      return tiles();
    case VdbKind::kLevelSet:
      return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(12, {1, 2, 3}, 1);
    case VdbKind::kEmpty:
      return newGrid<openvdb::FloatGrid>(1);
    case VdbKind::kVec3:
      return single<openvdb::Vec3SGrid>(openvdb::Vec3s(1, 2, 3));
    case VdbKind::kBool:
      return single<openvdb::BoolGrid>(true);
    case VdbKind::kMask:
      return single<openvdb::MaskGrid>(true);
    case VdbKind::kPointIndex:
      return points<openvdb::tools::PointIndexGrid>();
    case VdbKind::kPointData:
      return points<openvdb::points::PointDataGrid>();
  }
  throw std::logic_error("kind");
}

}  // namespace

double vdbValue(const VoxelCoord& v) { return static_cast<double>(((v.x * 37 + v.y * 101 + v.z * 211) & 2047) - 1024); }

void writeVdb(const std::filesystem::path& path, const std::vector<VdbSpec>& specs, bool seekable,
              VdbCompression compression) {
  using namespace openvdb::io;
  const std::uint32_t flags = compression == VdbCompression::kBlosc          ? COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK
                              : compression == VdbCompression::kZip          ? COMPRESS_ZIP | COMPRESS_ACTIVE_MASK
                              : compression == VdbCompression::kActiveValues ? COMPRESS_ACTIVE_MASK
                                                                             : COMPRESS_NONE;
  openvdb::initialize();
  openvdb::GridPtrVec grids;
  for (const VdbSpec& spec : specs) {
    openvdb::GridBase::Ptr grid = gridOf(spec);
    grid->setName(spec.name);
    grid->setSaveFloatAsHalf(spec.kind == VdbKind::kHalf);
    grid->setTransform(spec.kind == VdbKind::kFrustum ? openvdb::math::Transform::createFrustumTransform(
                                                            openvdb::BBoxd({0, 0, 0}, {10, 10, 10}), 0.5, 10)
                                                      : transformOf(spec.world_from_grid));
    grids.push_back(grid);
  }
  if (seekable) {
    openvdb::io::File file(path.string());
    file.setCompression(flags);
    file.write(grids);
    file.close();
  } else {
    std::ofstream out(path, std::ios::binary);
    openvdb::io::Stream stream(out);
    stream.setCompression(flags);
    stream.write(grids);
  }
}

std::vector<std::uint8_t> earlyVdb() {
  std::vector<std::uint8_t> out;
  const auto put = [&]<class T>(T value) {
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof value);
  };
  const auto text = [&](const std::string& words) {
    put(static_cast<std::uint32_t>(words.size()));
    out.insert(out.end(), words.begin(), words.end());
  };
  const auto zeros = [&](std::size_t bytes) { out.resize(out.size() + bytes); };
  // Writes a node's mask of `bits` children or values: only the first bit is on, or none.
  const auto mask = [&](std::size_t bits, bool first) {
    zeros(bits / 8);
    if (first) out[out.size() - bits / 8] = 1;
  };
  put(std::int64_t{0x56444220});
  put(std::uint32_t{221});
  put(std::uint32_t{1});  // version of the library
  put(std::uint32_t{2});
  put(std::uint8_t{0});  // no offsets of grids
  put(std::uint8_t{0});  // not compressed
  for (const char c : std::string("00000000-0000-0000-0000-000000000000")) put(c);
  put(std::uint32_t{0});  // metadata
  put(std::int32_t{1});   // grids
  text("density");
  text("Tree_float_5_4_3");
  text("");
  for (int i = 0; i < 3; ++i) put(std::int64_t{0});
  put(std::uint32_t{1});
  text("class");
  text("string");
  text("fog volume");
  text("UniformScaleMap");
  for (const double scale : {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}) put(scale);
  put(std::int32_t{1});   // buffers
  put(0.0f);              // background
  put(std::uint32_t{0});  // tiles of the root
  put(std::uint32_t{1});  // children
  zeros(3 * sizeof(std::int32_t));
  for (const std::size_t children : {std::size_t{1} << 15, std::size_t{1} << 12}) {
    mask(children, true);                   // mask of children
    mask(children, false);                  // mask of active tiles
    zeros((children - 1) * sizeof(float));  // the child has no value
  }
  out.insert(out.end(), 64, 0xff);
  out.insert(out.end(), 64, 0xff);
  zeros(3 * sizeof(std::int32_t));
  put(std::int8_t{1});  // buffers
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) put(static_cast<float>(x + 8 * y + 64 * z));
    }
  }
  return out;
}

struct DirectGrid::Grid {
  openvdb::GridBase::Ptr base;
  bool half = false;

  template <class F>
  auto with(F&& f) const {
    if (auto p = openvdb::gridConstPtrCast<openvdb::FloatGrid>(base)) return f(*p);
    if (auto p = openvdb::gridConstPtrCast<openvdb::DoubleGrid>(base)) return f(*p);
    if (auto p = openvdb::gridConstPtrCast<openvdb::Int32Grid>(base)) return f(*p);
    if (auto p = openvdb::gridConstPtrCast<openvdb::Int64Grid>(base)) return f(*p);
    throw std::logic_error("grid type " + base->type());
  }
};

DirectGrid::DirectGrid(const std::filesystem::path& path, const std::string& name) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(/*delayLoad=*/false);
  auto grid = std::make_shared<Grid>();
  grid->base = file.readGrid(name);
  grid->half = grid->base->saveFloatAsHalf();
  grid_ = grid;
}

std::string DirectGrid::type() const { return grid_->base->valueType(); }
bool DirectGrid::levelSet() const { return grid_->base->getGridClass() == openvdb::GRID_LEVEL_SET; }
bool DirectGrid::savedAsHalf() const { return grid_->half; }
std::uint64_t DirectGrid::activeVoxels() const { return grid_->base->activeVoxelCount(); }

double DirectGrid::background() const {
  return grid_->with([](const auto& grid) { return static_cast<double>(grid.background()); });
}

int DirectGrid::unitExponent() const {
  const auto found = grid_->base->getMetadata<openvdb::Int32Metadata>("kiln_unit_exponent");
  return found ? found->value() : 0;
}

glm::dmat4 DirectGrid::worldFromGrid() const {
  // Compares the images of points, not the matrix.
  const auto at = [&](double x, double y, double z) {
    const openvdb::Vec3d p = grid_->base->transform().indexToWorld(openvdb::Vec3d(x, y, z));
    return glm::dvec4(p.x(), p.y(), p.z(), 1);
  };
  const glm::dvec4 origin = at(0, 0, 0);
  return {at(1, 0, 0) - origin, at(0, 1, 0) - origin, at(0, 0, 1) - origin, origin};
}

VoxelBox DirectGrid::activeBox() const {
  const openvdb::CoordBBox b = grid_->base->evalActiveVoxelBoundingBox();
  return {{b.min().x(), b.min().y(), b.min().z()}, {b.max().x() + 1, b.max().y() + 1, b.max().z() + 1}};
}

double DirectGrid::value(const VoxelCoord& v) const {
  return grid_->with([&](const auto& grid) { return static_cast<double>(grid.tree().getValue(coordOf(v))); });
}

bool DirectGrid::active(const VoxelCoord& v) const {
  return grid_->with([&](const auto& grid) { return grid.tree().isValueOn(coordOf(v)); });
}

std::array<float, 3> DirectGrid::color(const VoxelCoord& v) const {
  const auto grid = openvdb::gridConstPtrCast<openvdb::Vec3SGrid>(grid_->base);
  const openvdb::Vec3f value = grid->tree().getValue(coordOf(v));
  return {value.x(), value.y(), value.z()};
}

std::vector<std::pair<VoxelCoord, double>> DirectGrid::activeValues() const {
  std::vector<std::pair<VoxelCoord, double>> out;
  grid_->with([&](const auto& grid) {
    for (auto value = grid.cbeginValueOn(); value; ++value) {
      if (!value.isVoxelValue()) throw std::runtime_error("an active tile");
      const openvdb::Coord c = value.getCoord();
      out.emplace_back(VoxelCoord{c.x(), c.y(), c.z()}, static_cast<double>(*value));
    }
  });
  return out;
}

std::vector<std::string> gridNames(const std::filesystem::path& path) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(/*delayLoad=*/false);
  std::vector<std::string> out;
  for (auto name = file.beginName(); name != file.endName(); ++name) out.push_back(*name);
  return out;
}

namespace {
class SeekableArchive : public openvdb::io::Archive {
 public:
  void writeTo(std::ostream& out, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata) {
    setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    setGridStatsMetadataEnabled(false);
    Archive::write(out, grids, /*seekable=*/true, metadata);
  }
};

// Returns the bytes of an archive with change(grid) for every grid of the file, and the file's metadata.
template <class Change>
std::vector<std::byte> writtenWith(const std::filesystem::path& path, Change&& change) {
  openvdb::initialize();
  std::ifstream in(path, std::ios::binary);
  openvdb::io::Stream stream(in, /*delayLoad=*/false);
  openvdb::GridPtrVec grids = *stream.getGrids();
  for (openvdb::GridBase::Ptr& grid : grids) grid = change(grid);
  std::ostringstream out;
  SeekableArchive().writeTo(out, grids, *stream.getMetadata());
  const std::string bytes = std::move(out).str();
  const auto* const first = reinterpret_cast<const std::byte*>(bytes.data());
  return {first, first + bytes.size()};
}
}  // namespace

std::vector<std::byte> writtenAgain(const std::filesystem::path& path) {
  return writtenWith(path, [](const openvdb::GridBase::Ptr& grid) { return grid; });
}

std::vector<std::byte> writtenAsFloat(const std::filesystem::path& path, bool half) {
  initializeOpenVdb();
  blosc_set_splitmode(BLOSC_FORWARD_COMPAT_SPLIT);
  std::vector<std::byte> bytes = writtenWith(path, [half](const openvdb::GridBase::Ptr& grid) {
    const auto from = openvdb::gridPtrCast<openvdb::Int32Grid>(grid);
    const auto to = newGrid<openvdb::FloatGrid>(0);
    to->setName(from->getName());
    to->setTransform(from->transformPtr());
    to->setSaveFloatAsHalf(half);
    auto accessor = to->getAccessor();
    for (auto value = from->cbeginValueOn(); value; ++value)
      accessor.setValueOn(value.getCoord(), static_cast<float>(*value));
    return to;
  });
  blosc_set_splitmode(BLOSC_NEVER_SPLIT);
  return bytes;
}

}  // namespace kiln::test
