// OpenVDB files and brick files, written and read as by another program: with OpenVDB's own io::File and accessors.
// Nothing is shared with the tested reader, neither the stream nor the dense copy.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "grid/coords.h"

namespace kiln::test {

/// Contents of a test grid. The scalar grids fill a box at kVdbOrigin with vdbValue; each seventh voxel is inactive.
enum class VdbKind {
  kFloat,
  kHalf,
  kDouble,
  kInt32,     // fog
  kTiles,     // float: an active tile of 8³, a filled 20×20×20 box, one voxel
  kLevelSet,  // float: a ball of radius 12 voxels
  kEmpty,     // float, no active voxel
  kFrustum,   // float with a perspective transform
  kVec3,
  kBool,
  kMask,
  kInt64,     // fog
  kWide,      // Int64, values beyond 32 bits
  kUnsigned,  // Int64, values from 0 to 2^32 - 1
  kFar,       // float: two voxels, 5 apart along each axis, the first at VdbSpec::at
  kPointIndex,
  kPointData  // no scalar volume
};

inline constexpr VoxelCoord kVdbOrigin = {-13, 5, -9};
inline constexpr Extent3 kVdbDims = {13, 9, 11};
inline constexpr double kVdbBackground = 3;
/// An integer in [-1024, 1023], representable by every scalar type and half, and different from its neighbours.
double vdbValue(const VoxelCoord& grid_coord);

struct VdbSpec {
  VdbKind kind = VdbKind::kFloat;
  std::string name = "density";
  /// Ignored for frustums.
  glm::dmat4 world_from_grid{1.0};
  VoxelCoord at = {};
};

/// Compression of a file's trees. Blosc is OpenVDB's default, with active values only.
enum class VdbCompression { kBlosc, kZip, kActiveValues, kNone };

/// `seekable` false writes as to a pipe, without grid offsets.
void writeVdb(const std::filesystem::path& path, const std::vector<VdbSpec>& specs, bool seekable = true,
              VdbCompression compression = VdbCompression::kBlosc);

/// A file of a single grid with a single full leaf, uncompressed, in the format of version 221, before OpenVDB 2.0.
/// shape: voxel (x, y, z) of the box 8 x 8 x 8 at 0 is x + 8 y + 64 z.
std::vector<std::uint8_t> earlyVdb();

/// A grid as OpenVDB itself reads it.
class DirectGrid {
 public:
  DirectGrid(const std::filesystem::path& path, const std::string& name);
  std::string type() const;  // "float", "double", "int32", …
  bool levelSet() const;
  bool savedAsHalf() const;
  double background() const;
  glm::dmat4 worldFromGrid() const;
  /// The metadata kiln_unit_exponent; 0 without.
  int unitExponent() const;
  /// Box of the active voxels and tiles.
  VoxelBox activeBox() const;
  std::uint64_t activeVoxels() const;
  double value(const VoxelCoord& grid_coord) const;
  bool active(const VoxelCoord& grid_coord) const;
  /// The value of a grid of three floats.
  std::array<float, 3> color(const VoxelCoord& grid_coord) const;
  /// Returns all active voxels with their values, in the tree's order. throws: std::runtime_error for active tiles.
  std::vector<std::pair<VoxelCoord, double>> activeValues() const;

 private:
  struct Grid;
  std::shared_ptr<const Grid> grid_;
};

/// The names of all grids of a file, in alphabetical order.
std::vector<std::string> gridNames(const std::filesystem::path& path);

/// Rewrites the file's grids and metadata with OpenVDB's own archive and returns the bytes, with the file's order of
/// grids and with Blosc and active-mask compression. The 36 bytes of the UUID are random.
std::vector<std::byte> writtenAgain(const std::filesystem::path& path);
/// Rewrites a brick file of Int32 grids with float grids, saved as half or not, in Blosc's split blocks. thread: while
/// nothing else compresses.
std::vector<std::byte> writtenAsFloat(const std::filesystem::path& path, bool half);

}  // namespace kiln::test
