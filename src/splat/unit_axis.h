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

/// Four voxels of each sample and their weights. A voxel without weight is none of them: it may be NaN.
struct CubicTaps {
  // shape: tap, sample.
  std::array<std::array<std::int32_t, kUnitSamples>, 4> at{};  // counted from the first voxel that is read
  std::array<std::array<float, kUnitSamples>, 4> weight{};
};

/// Where the samples along one axis of a unit lie: voxel cube i carries n at i - 1/2 + (2k+1)/(2n).
struct UnitAxis {
  int refinement = 1;
  int samples = 1;                                // of a whole unit
  std::array<float, kUnitSamples> offset{};       // from the unit's first voxel. unit: voxels
  std::array<std::int32_t, kUnitSamples> base{};  // the voxel before it, counted from the first that is read
  std::array<float, kUnitSamples> fraction{};     // towards the next voxel
  CubicTaps value, smooth, slope;                 // of a cubic: of values; of the B-spline and of its derivative
  UnitAxis() = default;
  UnitAxis(int refinement, int voxels, Interpolation interpolation);
};

}  // namespace kiln
