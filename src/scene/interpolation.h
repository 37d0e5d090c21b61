// How values between voxels are found where samples are nearer to each other than voxels.
#pragma once

namespace kiln {

/// Separable filters over the voxels around a place; beyond the volume the nearest voxel goes on.
/// - kLinear: trilinear, of 2³ voxels.
/// - kCubic: the cubic B-spline, of 4³: smooth to its second derivative; it blurs, voxels' own values, too.
/// - kCatmullRom: of 4³: goes through the voxels with a smooth first derivative, and is kept within the range of the
///   voxels that it takes.
enum class Interpolation { kLinear, kCubic, kCatmullRom };

}  // namespace kiln
