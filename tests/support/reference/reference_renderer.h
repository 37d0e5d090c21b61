// The judge of every picture: a ray caster in double precision that is slow and obviously right. It shares with the
// renderer only what defines the picture (View, TransferFunction, Shading) and none of what makes it fast: no bricks,
// no pyramid, no occlusion, no tables.
//
// The picture: the volume is the interpolation (trilinear, or a cubic of scene/interpolation.h) of its voxels on [-1/2,
// N-1/2)³ of index space, beyond which the nearest voxel goes on. The transfer function classifies the interpolated
// value; light is absorbed and emitted along each ray by the formulas of tools/kiln/manual/render.md. Perspective rays
// start at the eye; orthographic rays cross the whole volume.
#pragma once

#include <array>
#include <vector>

#include "image/image.h"
#include "job/render_job.h"
#include "scene/camera/camera.h"
#include "scene/transfer/transfer_function.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// A central difference (index units) shorter than this part of the volume's value range has no direction worth the
/// name: the sample is unshaded. So is one next to a NaN, whose gradient is NaN.
inline constexpr double kGradientNoise = 1e-5;

struct ReferenceSettings {
  /// n × n regular rays a pixel.
  int rays_per_axis = 4;
  /// unit: the smallest voxel spacing.
  double step_voxels = 0.1;
  /// A ray that reaches this alpha is divided by it and ends; 1: never.
  double opacity_threshold = 1;
  /// Steps over what is transparent without sampling it, which changes no bit of the picture.
  bool skip_empty = true;
  /// Rays end at its faces exactly. Within a voxel of one (its extent along the normal) the normal is the face's.
  Clipping clipping = {};
  Interpolation interpolation = Interpolation::kLinear;
  /// Over how many voxels to either side opacities of labels are smoothed for their gradients.
  int label_smoothing = 0;

  /// What VTK and the like draw: one ray a pixel, a step of one voxel.
  static ReferenceSettings vtkLike() { return {1, 1.0, 1}; }
};

/// The picture. shape: view.size. `background` is linear and premultiplied. thread: uses all.
Image referenceImage(const DenseVolume& volume, const View& view, const TransferFunction& transfer_function,
                     const Shading& shading, const std::array<double, 4>& background = {0, 0, 0, 0},
                     const ReferenceSettings& settings = {});

/// A volume of several in one picture.
struct ReferenceVolume {
  const DenseVolume* volume = nullptr;
  TransferFunction transfer_function;
  Shading shading = {};
  Clipping clipping = {};
};
/// The picture of all of them: where they overlap, their extinctions add up, and light comes from each as much as it
/// absorbs. The settings' clipping says nothing; steps are as short as the smallest spacing of all asks for.
Image referenceImage(const std::vector<ReferenceVolume>& volumes, const View& view,
                     const ReferenceSettings& settings = {});

/// Absorption alone, in doubles. shape: view.size, row 0 at the top.
struct OpticalDepthImage {
  int width = 0, height = 0;
  std::vector<double> depth;          // ∫τ ds, the mean over the pixel's rays
  std::vector<double> transmittance;  // exp(-∫τ ds), the mean over the pixel's rays
};
OpticalDepthImage opticalDepthImage(const DenseVolume& volume, const View& view,
                                    const TransferFunction& transfer_function, const ReferenceSettings& settings = {});

/// How far along the ray through a pixel's centre, from Ray::origin, alpha passes one half; infinity where it does not.
/// shape: view.size, row 0 at the top. unit: world.
std::vector<double> firstHits(const DenseVolume& volume, const View& view, const TransferFunction& transfer_function,
                              ReferenceSettings settings = {});

/// What `--mode mip|minip|average` projects along the ray through each pixel's centre, in doubles: NaN where the ray
/// meets no value. shape: view.size, row 0 at the top. Of the settings, rays_per_axis, threshold and skip_empty say
/// nothing.
struct ProjectedImage {
  int width = 0, height = 0;
  std::vector<double> greatest, least, mean;
};
ProjectedImage projectedImage(const DenseVolume& volume, const View& view, const ReferenceSettings& settings = {});

/// A ray of the picture in world space.
struct Ray {
  glm::dvec3 origin, direction;  // direction has unit length
  double begin;                  // distance from origin where it starts: 0, or -infinity for parallel rays
};
Ray rayThrough(const View& view, const glm::dvec2& pixel);

}  // namespace kiln::test
