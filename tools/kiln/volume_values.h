// The values of a store or of a volume file, for commands that print them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "convert/foreign_cache.h"
#include "source_arguments.h"
#include "store/manifest/manifest.h"

namespace kiln::tool {

/// True if the path is a volume that is no store: a file, a folder of slices, or a phantom.
bool namesVolumeFile(const std::filesystem::path& path, const SourceWords& arguments);

struct VolumeValues {
  /// Geometry, type, range and histogram.
  Manifest manifest;
  /// The counted voxels, as "5 of 9 voxels"; empty if the volume is a store.
  std::string counted;
  /// unit: voxels. 0 if a store has all values.
  std::uint64_t sampled = 0;
};

/// Returns the values of an open volume file: those of the store that was made of it, else of a sample.
/// throws: Error kBudget if they do not fit `memory_bytes`, and the exceptions of the source.
VolumeValues valuesOf(const ForeignVolume& volume, VolumeSource& source, std::uint64_t memory_bytes,
                      Progress& progress);

/// Prints the histogram, a range of values a line; nothing for a volume without values.
void sayHistogram(const VolumeValues& values);
/// Prints windows that show the volume, for --window.
void sayWindows(const Manifest& manifest);

}  // namespace kiln::tool
