// The user's words on how a volume lies in the world. Voxels keep their order and values: the affine and the patient
// frame change.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "grid/geometry.h"

namespace kiln {

/// The directions in which the voxel axes x, y, z grow in a patient. shape: three letters, one of R L (right, left),
/// one of A P (anterior, posterior) and one of S I (superior, inferior); capital.
using AxisLetters = std::string;

/// Returns the letters in capitals; empty if `text` is none of the 48 orientations.
std::optional<AxisLetters> axisLettersOf(std::string_view text);

enum class UpAxis { kZ, kY };

struct Placement {
  /// Voxel axes along which the volume is mirrored within its box.
  std::array<bool, 3> flip{};
  /// For a volume without a patient frame.
  std::optional<AxisLetters> axes;
  /// The world axis of the file that points up. The world of a store has z up.
  UpAxis up = UpAxis::kZ;

  bool none() const { return *this == Placement(); }
  bool operator==(const Placement&) const = default;
};

/// Returns the geometry of a volume placed so. Voxel (0,0,0) keeps its place under `axes`, and the box keeps its place
/// under `flip`. throws: Error kUsage, naming `file` and the option, if the file states what the option would.
VolumeGeometry placed(const VolumeGeometry& geometry, const Placement& placement, const std::string& file);

}  // namespace kiln
