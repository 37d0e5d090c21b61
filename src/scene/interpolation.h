// Interpolation of values between voxels.
#pragma once

#include <array>
#include <string_view>

namespace kiln {

/// Separable filters over the neighbouring voxels; beyond the volume the nearest voxel is repeated.
/// - kLinear: trilinear, 2³ voxels.
/// - kCubic: the cubic B-spline, 4³ voxels: smooth to the second derivative; it blurs, also at voxel centres.
/// - kCatmullRom: 4³ voxels: interpolates voxel values with a smooth first derivative, clamped to the range of its
///   voxels.
enum class Interpolation { kLinear, kCubic, kCatmullRom };
inline constexpr std::array<std::string_view, 3> kInterpolationNames = {"linear", "cubic", "catmull-rom"};

}  // namespace kiln
