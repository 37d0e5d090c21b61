// Reference renderer, the truth for every picture: a slow and simple ray caster in double precision. It shares with the
// renderer only the picture's definition (View, TransferFunction, Shading). No bricks, no pyramid, no occlusion, no
// tables.
//
// Picture: the volume is the interpolation (trilinear, or a cubic of scene/render_options.h) of its voxels on [-1/2,
// N-1/2)³ of index space, extended by the nearest voxel. The transfer function classifies the interpolated value; each
// ray integrates emission and absorption by the formulas of tools/kiln/manual/render.md. Perspective rays start at the
// eye; orthographic rays cross the whole volume.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "image/image.h"
#include "job/render_job.h"
#include "scene/camera/camera.h"
#include "scene/transfer/transfer_function.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// A central difference (index units) below this share of the volume's value range has no reliable direction: the
/// sample is unshaded. Samples next to a NaN have a NaN gradient and are unshaded, too.
inline constexpr double kGradientNoise = 1e-5;

struct ReferenceSettings {
  /// n × n regular rays a pixel.
  int rays_per_axis = 4;
  /// unit: the smallest voxel spacing.
  double step_voxels = 0.1;
  /// A ray that reaches this alpha is divided by its alpha and ends; 1: never.
  double opacity_threshold = 1;
  /// Skips transparent blocks without sampling, which changes no bit of the picture.
  bool skip_empty = true;
  /// Rays end exactly at the faces of the clipping. Within a voxel of a face (its extent along the normal), or of the
  /// volume's border, the normal of the face is used; of several, the normal of the nearest towards the eye.
  Clipping clipping = {};
  Interpolation interpolation = Interpolation::kLinear;
  /// Height over a sample's surface at which layers begin to shadow the sample. unit: world.
  double shadow_start = 0;
  /// Random directions for each sample's ambient light; 0: no ambient occlusion.
  int occlusion_rays = 0;
  /// All samples have equal directions about their normals: pictures that differ a little have no noise between them.
  bool equal_occlusion_rays = false;
  /// Distance from a sample at which matter begins to occlude the sample, across its surface. unit: world.
  double occlusion_start = 0;
  /// Number of voxels to either side over which opacities of labels are smoothed for their gradients.
  int label_smoothing = 0;

  /// Settings like VTK's: one ray a pixel, a step of one voxel.
  static ReferenceSettings vtkLike() { return {1, 1.0, 1}; }
};

/// The picture. shape: view.size. `background` is linear and premultiplied. thread: uses all.
Image referenceImage(const DenseVolume& volume, const View& view, const TransferFunction& transfer_function,
                     const Shading& shading, const std::array<double, 4>& background = {0, 0, 0, 0},
                     const ReferenceSettings& settings = {});

/// A volume in a picture of several volumes.
struct ReferenceVolume {
  const DenseVolume* volume = nullptr;
  TransferFunction transfer_function;
  Shading shading = {};
  Clipping clipping = {};
};
/// Returns the picture of all volumes. Extinctions of overlapping volumes add up, and each contributes light in
/// proportion to its absorption. The settings' clipping is ignored; steps follow the smallest spacing of all volumes.
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

/// Returns the distance from Ray::origin, along the ray through a pixel's centre, at which alpha passes one half;
/// infinity if alpha stays below. shape: view.size, row 0 at the top. unit: world.
std::vector<double> firstHits(const DenseVolume& volume, const View& view, const TransferFunction& transfer_function,
                              ReferenceSettings settings = {});

/// Projections of `--mode mip|minip|average` along the ray through each pixel's centre, in doubles: NaN if the ray
/// meets no value. shape: view.size, row 0 at the top. The settings rays_per_axis, threshold and skip_empty are
/// ignored.
struct ProjectedImage {
  int width = 0, height = 0;
  std::vector<double> greatest, least, mean;
};
ProjectedImage projectedImage(const DenseVolume& volume, const View& view, const ReferenceSettings& settings = {});
/// Returns the greatest value along each ray, weakened by the values in front: with the share n of a value between the
/// ends of `values`, the greatest n·exp(-attenuation·∫n), as a value. unit: attenuation: per voxel.
std::vector<double> attenuatedImage(const DenseVolume& volume, const View& view, double attenuation,
                                    const ValueRange& values, const ReferenceSettings& settings = {});

/// A ray of the picture in world space.
struct Ray {
  glm::dvec3 origin, direction;  // direction has unit length
  double begin;                  // distance from origin to the start: 0, or -infinity for parallel rays
  double end = std::numeric_limits<double>::infinity();  // distance to the end
};
Ray rayThrough(const View& view, const glm::dvec2& pixel);

}  // namespace kiln::test
