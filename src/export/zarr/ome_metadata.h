// The headers of OME-Zarr 0.5 and Zarr 3 as text.
#pragma once

#include <string>
#include <vector>

#include "export/source/exported_volume.h"

namespace kiln {

/// zarr.json of the group: axes, and the place of each level. `volumes` are levels of one pyramid, the finest first.
std::string omeGroupText(const std::vector<ExportedVolume>& volumes, const std::string& name, ExportNotes& notes);

/// zarr.json of a level's array. shape: `shard` and `chunk` in voxels.
std::string zarrArrayText(const ExportedVolume& volume, const Extent3& shard, const Extent3& chunk);

}  // namespace kiln
