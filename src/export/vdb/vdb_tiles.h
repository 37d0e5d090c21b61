// Divides a volume into boxes side by side, each a grid that fits into memory alone.
#pragma once

#include <filesystem>
#include <vector>

#include "export/source/exported_volume.h"

namespace kiln {

/// Returns `count` parts of a volume, of about equal extents, that meet at multiples of the leaves' edge. No voxel is
/// in two parts: interpolated densities of neighbours add to those of the whole. throws: Error kUsage, naming `out`, if
/// the volume is too small for so many.
std::vector<ExportedVolume> tilesOf(const ExportedVolume& volume, int count, const std::filesystem::path& out);

/// Returns the name of a tile, counted from 1: the number in place of the last run of #, with zeros in front. throws:
/// Error kUsage if the name has no #.
std::filesystem::path pathOfTile(const std::filesystem::path& out, int tile);

}  // namespace kiln
