// Places the volumes of a picture in one world with one patient frame and one unit of length.
// A volume of another frame is rotated by a half turn about z (RAS and LPS differ in the signs of x and y). A volume of
// another unit is scaled.
#pragma once

#include <string>
#include <vector>

#include "grid/geometry.h"
#include "grid/length_unit.h"

namespace kiln {

/// The world of a picture: the first known frame and the first known unit; all further members are the first volume's.
/// requires: at least one volume.
VolumeGeometry sharedWorld(const std::vector<VolumeGeometry>& volumes);

/// The change from a volume's own world to a shared world.
struct WorldChange {
  bool turned = false;  // the signs of x and y change
  LengthRatio lengths;
  bool none() const { return !turned && lengths == LengthRatio(); }
  /// The affine in the shared world; equal to `world_from_index`, bit for bit, if nothing changes.
  glm::dmat4 of(const glm::dmat4& world_from_index) const;
};

/// A frame or unit that is unknown in either world stays unchanged.
WorldChange worldChange(const VolumeGeometry& own, const VolumeGeometry& world);

/// Returns a sentence on each frame or unit of `own` that is unknown or not convertible and is taken as the shared
/// world's; empty if there is none.
std::string assumptionText(const VolumeGeometry& own, const VolumeGeometry& world);

}  // namespace kiln
