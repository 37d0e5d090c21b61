// The volume in a Zarr array: which axes are x, y and z, the indices along all other axes, and the place in the world.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/source/volume_source.h"
#include "ingest/zarr/zarr_array.h"

namespace kiln {

struct ZarrVolume {
  VolumeGeometry geometry;
  /// The array's axis that is x, y and z; -1 for an axis that the array lacks, which is one voxel long.
  std::array<int, 3> axis_of = {-1, -1, -1};
  /// The index along every other axis; 0 along x, y and z.
  AxisNumbers fixed;
  VolumeClass volume_class = VolumeClass::kUnknown;
  /// For SourceInfo::format: the image, scale, channel and time that were chosen.
  std::string choice;
  std::vector<std::string> notes;
};

/// A channel of an image, as OME-Zarr's "omero" describes it.
struct ZarrChannel {
  std::string name;
};

/// An axis as the metadata describe it; texts are empty where unknown.
struct ZarrAxis {
  /// "x", "y", "z", "c", "t", or any other text.
  std::string name;
  std::string unit;
  /// RFC-4: "left-to-right" and similar.
  std::string orientation;
  double scale = 1, translation = 0;
};

/// Places a volume by its axes. `has_scale` is false if no metadata gave a length; a note then says so.
/// throws: Error kUnsupported if there is no volume in these axes; kUsage for a channel or time that does not exist or
/// is not chosen.
ZarrVolume volumeOf(const ZarrArray& array, std::vector<ZarrAxis> axes, bool has_scale,
                    const std::vector<ZarrChannel>& channels, const SourceOptions& options);

}  // namespace kiln
