// Opens a foreign volume: a file of any supported format, or an array in memory.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "ingest/source/volume_source.h"

namespace kiln {

/// Refuses options that describe voxels, because a store contains the description. throws: Error kUsage, naming the
/// option.
void requireNoOptions(const std::filesystem::path& store, const SourceOptions& options);

/// A part of a file is named FILE:/PATH, such as scan.h5:/entry/data. Returns FILE if FILE exists and `input` does not;
/// otherwise `input`.
std::filesystem::path containerOf(const std::filesystem::path& input);

/// Returns /PATH of the input FILE:/PATH (containerOf); empty for any other input.
std::string partOf(const std::filesystem::path& input);

/// Opens `input` by its content (the first bytes, then the name); a directory by its slices.
/// throws: Error kNotFound; kFormat; kUnsupported (naming the content: vector data, an unknown format); kUsage if
/// raw data come without --dims and --type, or an option does not apply to the format; kBudget, before reading a grid
/// larger than `options.memory_bytes`.
std::unique_ptr<VolumeSource> openSource(const std::filesystem::path& input, const SourceOptions& options = {});

/// An array in memory. The caller keeps its voxels alive and unchanged.
struct VoxelArray {
  const void* voxels = nullptr;  // the voxel (0, 0, 0)
  VoxelType type = VoxelType::u8;
  VolumeGeometry geometry;  // its dims, and its place in the world
  /// Distances between neighbours along x, y and z, of any sign; voxels need no alignment. Absent: x fastest, densely
  /// packed. unit: bytes.
  std::optional<std::array<std::int64_t, 3>> strides;
  VolumeClass volume_class = VolumeClass::kUnknown;
};

/// The format of an array, and its name in errors.
inline constexpr const char* kArrayName = "array";

/// Opens an array, for a conversion without a file. throws: Error kUsage without voxels; kFormat for dims or an affine
/// that no volume has.
std::unique_ptr<VolumeSource> arraySource(const VoxelArray& array);

}  // namespace kiln
