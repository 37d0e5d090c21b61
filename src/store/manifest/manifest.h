// The manifest of a store (FORMAT.md, manifest.json), as a struct and as checked text.
#pragma once

#include <array>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/hash.h"
#include "grid/geometry.h"
#include "grid/value_range.h"
#include "grid/volume_info.h"
#include "grid/voxel_type.h"

namespace kiln {

inline constexpr int kFormatVersion = 5;
/// The format of stores whose source declares no look.
inline constexpr int kFormatWithoutLook = 4;
/// The oldest format that is still read.
inline constexpr int kFirstFormatVersion = 1;
inline constexpr std::int64_t kApron = 6;
inline constexpr std::int64_t kDefaultBrickSize = 128;

/// Numbers of voxels in `counts.size()` equal bins of [lo, hi].
struct ValueHistogram {
  double lo = 0, hi = 0;
  std::vector<std::uint64_t> counts;
};

struct LevelInfo {
  VolumeGeometry geometry;
  Extent3 bricks;
  std::uint64_t stored_bricks = 0;
  /// Sum over all brick files of the level. unit: bytes.
  std::uint64_t stored_bytes = 0;
};

struct Provenance {
  std::string format;
  std::vector<std::string> files;
  /// State of the files when they were read (convert/resume/source_state.h); empty if unknown.
  std::string state;
  std::string command;
  std::string time;  // ISO 8601, UTC; given by the caller of the conversion
  std::optional<VdbOrigin> vdb;
};

struct Manifest {
  int format = kFormatWithoutLook;
  VoxelType type = VoxelType::u8;
  ValueRange range;
  std::uint64_t nan_count = 0;
  ValueHistogram histogram;
  double background = 0;
  VolumeClass volume_class = VolumeClass::kUnknown;
  /// In stores of format 5.
  DeclaredLook look;
  std::int64_t brick_size = kDefaultBrickSize;
  std::int64_t apron = kApron;
  std::vector<LevelInfo> levels;
  std::string container_version;
  Provenance source;
  std::uint64_t index_bytes = 0;
  Hash128 index_checksum;

  const VolumeGeometry& geometry() const { return levels.front().geometry; }
  /// Size of a voxel of a level along each axis. unit: voxels of level 0.
  Extent3 spanOf(int level) const;
  /// Sets the brick lattice of each level from the level's extent.
  void layBricks();
  /// The brick lattice of each level, as an index takes them.
  std::vector<Extent3> lattices() const;

  /// Lengths in the world per length in the volume's own world; 1 unless `placeIn` has scaled the volume. Not part of
  /// the file.
  double world_per_own = 1;
  /// A sentence on assumptions that `placeIn` made about unknown frames or units; empty if there are none.
  std::string assumption;
  /// The mean spacing in the volume's own unit, in whatever world the volume is placed.
  double ownMeanSpacing() const { return geometry().meanSpacing() / world_per_own; }
  /// Moves all levels of the volume into the frame and unit of `world` (grid/shared_world.h). Changes no bit of the
  /// geometry if frame and unit are equal.
  void placeIn(const VolumeGeometry& world);
};

/// Largest number of labels with a histogram bin each.
inline constexpr std::size_t kMostLabels = 65536;
/// True if the histogram has a bin per label: labels of 8 and 16 bits, and labels of wider types from 0 to 65534. False
/// for a volume that holds no labels.
bool countsEachLabel(VolumeClass volume_class, VoxelType type, const ValueRange& range);

/// The words of manifest.json.
const char* wordOf(VolumeClass volume_class);
const char* wordOf(PatientFrame frame);
/// The affine of manifest.json: row by row. shape: 4 × 4.
std::array<double, 16> rowsOf(const glm::dmat4& affine);

/// Returns the text of manifest.json, including the checksum.
std::string manifestText(const Manifest& manifest);
/// throws: Error, naming `path`: kDamaged (checksum), kFormat (unknown format number, a missing or wrong key).
Manifest parseManifest(const std::string& text, const std::filesystem::path& path);

}  // namespace kiln
