// The volume that a file gets: a box of one level of a store, and its place in the world.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "store/store_reader.h"

namespace kiln {

/// Sentences for the user about facts that a format cannot hold.
using ExportNotes = std::vector<std::string>;

struct ExportedVolume {
  int level = 0;
  /// The voxels, in the coordinates of the level.
  VoxelBox box;
  /// The geometry of `box`: its extent, and an affine from its own indices to the world.
  VolumeGeometry geometry;
  VoxelType type = VoxelType::u8;
  VolumeClass volume_class = VolumeClass::kUnknown;
  double background = 0;

  std::uint64_t bytes() const { return static_cast<std::uint64_t>(box.count()) * sizeOf(type); }
};

/// Returns the voxels of a level that meet `region`, a box of voxels of level 0; without a region all voxels. requires:
/// the store has the level. throws: Error kUsage if the region holds nothing of the volume.
ExportedVolume exportedVolume(const StoreReader& store, int level, const std::optional<VoxelBox>& region);

/// Returns a text that identifies the voxels of a part of a store, and their place. Exports of equal texts and options
/// are equal.
std::string identityOf(const StoreReader& store, const ExportedVolume& volume);

/// Returns the affine of a world whose axes have the directions of `frame`. An unknown frame, given or wanted, changes
/// nothing.
glm::dmat4 affineIn(PatientFrame frame, const VolumeGeometry& geometry);

/// Returns the geometry with its lengths in one of `units`: unchanged if it has such a unit or none, else in the first
/// of `units`. A unit of unknown length is removed. Adds a note for each change.
VolumeGeometry withUnitOf(std::initializer_list<std::string_view> units, const VolumeGeometry& geometry,
                          ExportNotes& notes);

/// True if spacings alone place the voxels: axes unturned, and the first voxel at the origin.
bool isPlacedBySpacing(const VolumeGeometry& geometry);

/// "64 x 64 x 32 voxels of u16".
std::string extentText(const ExportedVolume& volume);

}  // namespace kiln
