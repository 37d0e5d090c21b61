// Volumes of a picture share a world: a patient frame and a unit of length. A volume of another frame is turned by half
// a turn about z (RAS and LPS differ in the signs of x and y). A volume of another unit is scaled.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "grid/geometry.h"

namespace kiln {

/// Units of `to` per unit of `from`, as a quotient of whole numbers: powers of ten are exact.
struct LengthRatio {
  double numerator = 1, denominator = 1;
  double of(double length) const { return length * numerator / denominator; }
  bool operator==(const LengthRatio&) const = default;
};

/// Empty if a name is no known unit of length. Two equal names are an equal unit, known or not.
std::optional<LengthRatio> lengthRatio(std::string_view from, std::string_view to);

/// The frame and unit of a picture of the volumes: the first known frame and the first known unit. All other members
/// are the first volume's. requires: a volume or more.
VolumeGeometry sharedWorld(const std::vector<VolumeGeometry>& volumes);

/// The steps from a volume's own world to a shared world.
struct WorldChange {
  bool turned = false;  // the signs of x and y change
  LengthRatio lengths;
  bool none() const { return !turned && lengths == LengthRatio(); }
  /// The affine in the shared world. Equal to `world_from_index`, bit for bit, if there is no change.
  glm::dmat4 of(const glm::dmat4& world_from_index) const;
};

/// An unknown frame or unit is left unchanged.
WorldChange worldChange(const VolumeGeometry& own, const VolumeGeometry& world);

/// A sentence on the unknown frame or unit of `own` for which the shared world's is assumed. Empty if no assumption is
/// made.
std::string assumptionText(const VolumeGeometry& own, const VolumeGeometry& world);

}  // namespace kiln
