// The volume in an array of several axes: which axes are x, y and z, the indices along all other axes, and the place in
// the world.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ingest/chunks/chunked_array.h"
#include "ingest/source/volume_source.h"

namespace kiln {

struct ArrayVolume {
  VolumeGeometry geometry;
  /// The array's axis for x, y and z; -1 for a missing axis, along which the volume is one voxel long.
  std::array<int, 3> axis_of = {-1, -1, -1};
  /// The index along every other axis; 0 along x, y and z.
  AxisNumbers fixed;
  /// The index along the axis of channels; 0 without one.
  std::int64_t channel = 0;
  DeclaredLook look;
  VolumeClass volume_class = VolumeClass::kUnknown;
  /// For SourceInfo::format: the image, scale, channel and time that were chosen.
  std::string choice;
  std::vector<std::string> notes;
};

/// An axis as the metadata describe it; texts are empty where unknown.
struct ArrayAxis {
  /// "x", "y", "z", "c", "t", "channel", "time", or any other text, in small or capital letters.
  std::string name;
  std::string unit;
  /// RFC-4: "left-to-right" and similar.
  std::string orientation;
  double scale = 1, translation = 0;
};

/// Returns a name in small letters; "c" and "t" for "channel" and "time".
std::string plainAxisName(const std::string& name);

/// Returns the axes x, y and z, -1 for a missing axis: the axes of these names. If there is no such name: the last
/// three but for times, channels and a nameless axis of one entry behind x, which programs write that store channels
/// last. requires: plain names.
std::array<int, 3> spaceAxes(const AxisNumbers& shape, const std::vector<ArrayAxis>& axes);

/// An array, as errors name it.
struct ArrayName {
  /// The file or folder that the user gave, and the file that describes the array.
  std::filesystem::path input, header;
  AxisNumbers shape;
};

/// Enters the volume's description behind what `info` has: its files, and the begin of the format's name.
void describe(const ArrayVolume& volume, VoxelType type, SourceInfo& info);

/// Returns a note that the attributes scale_factor and add_offset (CF conventions) are not applied; empty if they
/// change no value.
std::string noteOfScaled(double factor, double offset);

/// Places a volume by its axes; names those of an array whose axes have no names by place, the last three z, y and x,
/// which is the order of nearly all writers, behind channels and times. `channels` are names; fewer names than channels
/// are legal. `has_scale` is false if no metadata gave a length; a note then says so. throws: Error kUnsupported if
/// there is no volume in these axes; kUsage for a channel or time that does not exist or is not chosen.
ArrayVolume volumeOf(const ArrayName& array, std::vector<ArrayAxis> axes, bool has_scale,
                     const std::vector<std::string>& channels, const SourceOptions& options);

}  // namespace kiln
