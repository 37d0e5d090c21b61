// What a store says of itself (FORMAT.md, manifest.json), as a struct and as checked text.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/hash.h"
#include "grid/geometry.h"
#include "grid/value_range.h"
#include "grid/volume_info.h"
#include "grid/voxel_type.h"

namespace kiln {

inline constexpr int kFormatVersion = 4;
/// The first that is still read.
inline constexpr int kFirstFormatVersion = 1;
inline constexpr std::int64_t kApron = 6;
inline constexpr std::int64_t kDefaultBrickSize = 128;

/// Counts of voxels by value: `counts.size()` equal bins of [lo, hi].
struct ValueHistogram {
  double lo = 0, hi = 0;
  std::vector<std::uint64_t> counts;
};

struct LevelInfo {
  VolumeGeometry geometry;
  Extent3 bricks;
  std::uint64_t stored_bricks = 0;
  /// unit: bytes of all brick files.
  std::uint64_t stored_bytes = 0;
};

struct Provenance {
  std::string format;
  std::vector<std::string> files;
  std::string
      state;  // of the files when they were read (convert/resume/source_state.h); empty where nothing is known of it
  std::string command;
  std::string time;  // ISO 8601, UTC; what the caller of the conversion gave
  std::optional<VdbOrigin> vdb;
};

struct Manifest {
  int format = kFormatVersion;
  VoxelType type = VoxelType::u8;
  ValueRange range;
  std::uint64_t nan_count = 0;
  ValueHistogram histogram;
  double background = 0;
  VolumeClass volume_class = VolumeClass::kUnknown;
  std::int64_t brick_size = kDefaultBrickSize;
  std::int64_t apron = kApron;
  std::vector<LevelInfo> levels;
  std::string container_version;
  Provenance source;
  std::uint64_t index_bytes = 0;
  Hash128 index_checksum;

  const VolumeGeometry& geometry() const { return levels.front().geometry; }

  /// Lengths of the world per length of the volume's own world. Not part of the file: 1, but of a volume that `placeIn`
  /// has scaled.
  double world_per_own = 1;
  /// A sentence on what `placeIn` took for the same because it is unknown; empty where all is known.
  std::string assumption;
  /// The mean spacing in the volume's own unit, whatever world it is placed in.
  double ownMeanSpacing() const { return geometry().meanSpacing() / world_per_own; }
  /// Moves the volume, all levels of it, into the frame and unit of `world` (grid/shared_world.h). Changes no bit of
  /// the geometry where both are the same already.
  void placeIn(const VolumeGeometry& world);
};

/// The most labels that are counted one by one.
inline constexpr std::size_t kMostLabels = 65536;
/// Whether the histogram of labels in that range has a bin for each of them: those of 8 and 16 bits, and of wider types
/// those from 0 to 65534. False of what is no label volume.
bool countsEachLabel(VolumeClass volume_class, VoxelType type, const ValueRange& range);

/// The text of manifest.json, checksum included.
std::string manifestText(const Manifest& manifest);
/// throws: Error kDamaged (checksum), kFormat (another format number, a missing or wrong key), naming `path`.
Manifest parseManifest(const std::string& text, const std::filesystem::path& path);

}  // namespace kiln
