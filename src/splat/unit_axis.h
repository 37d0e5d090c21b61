// Where the samples along an axis of a unit lie, and which of its voxels they take with which weights. All three axes
// together make the separable filters of scene/interpolation.h.
//
// Gradients are at voxel scale. Of linear interpolation they are interpolated central differences; of either cubic the
// derivative of the cubic B-spline, which at a voxel is the central difference, smoothed across (ARCHITECTURE.md has
// the figures).
#pragma once

#include <array>
#include <cstdint>

#include "scene/interpolation.h"

namespace kiln {

/// Samples along an axis of a unit, at most.
inline constexpr int kUnitSamples = 16;
/// Voxels that are read around a unit: one for linear interpolation and one for its gradient, or two for a cubic, whose
/// gradient takes the same.
inline constexpr int kUnitMargin = 2;
/// Voxels along an axis of a unit, at most.
inline constexpr int kUnitVoxels = 8;
/// A whole number of samples along an axis falls to so many voxels, and to no fewer.
inline constexpr int kRefinedVoxels = 8;
/// The most samples a voxel's edge is refined into. Nearer to the eye, samples are more than a pixel apart and
/// footprints, slabs with them, as much larger.
inline constexpr int kLargestRefinement = 16;

/// Four voxels of each sample and their weights. A voxel without weight is none of them: it may be NaN.
struct CubicTaps {
  // shape: tap, sample.
  std::array<std::array<std::int32_t, kUnitSamples>, 4> at{};  // counted from the first voxel that is read
  std::array<std::array<float, kUnitSamples>, 4> weight{};
};

/// How finely an axis is sampled: evenly, so many samples in each kRefinedVoxels voxels, which need not be a whole
/// number of a voxel. Voxels are counted in index space, so that samples are the same whatever brick they are drawn
/// from.
struct Refinement {
  int samples = kRefinedVoxels;  // of kRefinedVoxels, and no fewer than these
  bool operator==(const Refinement&) const = default;
  double ofVoxel() const { return static_cast<double>(samples) / kRefinedVoxels; }
  /// How near to a face between voxels a sample may be. unit: voxels.
  double leastFromFace() const;
};

/// Whether a unit of so many voxels has room for its samples, and for one in the next voxel that reaches into it.
bool unitHasRoom(const Refinement& refinement, int voxels);

/// Where the samples along one axis of a unit lie. Of kRefinedVoxels voxels with n samples, which end half a voxel
/// before the first one's centre, the i-th is at (i + 1/2) / n; a unit has those in its voxels' cubes.
struct UnitAxis {
  int samples = 1;                            // of a whole unit; the arrays have the next one, too, if there is room
  double step = 1;                            // from one to the next. unit: voxels
  std::array<int, kUnitVoxels + 1> before{};  // a voxel, counted from the unit's first: so many samples
  std::array<float, kUnitSamples> offset{};   // from the unit's first voxel. unit: voxels
  std::array<std::int32_t, kUnitSamples> base{};  // the voxel before it, counted from the first that is read
  std::array<float, kUnitSamples> fraction{};     // towards the next voxel
  CubicTaps value, smooth, slope;                 // of a cubic: of values; of the B-spline and of its derivative
  UnitAxis() = default;
  /// `first` is the unit's first voxel, of kRefinedVoxels. requires: room for `voxels`, see unitHasRoom.
  UnitAxis(const Refinement& refinement, int first, int voxels, Interpolation interpolation);
  /// What of each sample is in the volume, which ends after `end` voxels of the unit: parts of the last ones, of which
  /// one may be in the voxel after it.
  std::array<float, kUnitSamples> partsBefore(double end) const;
};

}  // namespace kiln
