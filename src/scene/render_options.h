// Choices that engines and jobs share: occlusion tests, samples and their interpolation, projection of values,
// background, extra planes.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace kiln {

/// Returns the word of `names` for an enumerator.
template <class Names, class Enum>
constexpr std::string_view nameIn(const Names& names, Enum enumerator) {
  return names[static_cast<std::size_t>(enumerator)];
}

enum class VisibilityMethod { kNone, kMask, kRangeTree, kQuadtree, kOverlay };
/// The image rectangle of an octree node: around the projected box and footprint, or around the projected circumscribed
/// sphere (Lee and Ihm §2.2.3).
enum class ProjectedArea { kBox, kSphere };

inline constexpr int kLargestEpsilon = 65536;

/// Least edge of the tiles that threads draw. unit: pixels.
inline constexpr int kLeastTile_px = 64;

/// Options for finding hidden nodes.
struct VisibilityOptions {
  VisibilityMethod method = VisibilityMethod::kMask;
  ProjectedArea area = ProjectedArea::kBox;
  int epsilon_px = 0;  // kQuadtree: enlargement of projected areas on every side, at most kLargestEpsilon
  /// Skips samples whose own footprints lie on closed pixels, before shading; tested on the tile's pixels, with any
  /// method. Lee and Ihm test nodes only, and so does the quadtree.
  bool test_samples = true;
  bool operator==(const VisibilityOptions&) const = default;
};
/// Positions of samples (engine/pixel/decisions/places.md).
/// - kPixel: intersections of pixel rays and slabs; a sample contributes to its pixel only.
/// - kVoxel: voxels, splatted as by Lee and Ihm.
enum class Lattice { kPixel, kVoxel };
inline constexpr std::size_t kLatticeCount = 2;
/// The names of the lattices, followed by an alias of the first.
inline constexpr std::array<std::string_view, kLatticeCount + 1> kLatticeNames = {"pixel", "voxel", "ray"};

/// Separable filters over the neighbouring voxels; beyond the volume the nearest voxel is repeated.
/// - kLinear: trilinear, 2³ voxels.
/// - kCubic: the cubic B-spline, 4³ voxels: smooth to the second derivative; it blurs, also at voxel centres.
/// - kCatmullRom: 4³ voxels: interpolates voxel values with a smooth first derivative, clamped to the range of its
///   voxels.
enum class Interpolation { kLinear, kCubic, kCatmullRom };
inline constexpr std::array<std::string_view, 3> kInterpolationNames = {"linear", "cubic", "catmull-rom"};

/// Default and legal distances of samples. unit: voxels.
inline constexpr double kSampleDistance = 0.5, kLeastSampleDistance = 0.25, kMostSampleDistance = 1;

/// Combination of the values along a pixel's ray.
/// - kComposite: light of the volume, attenuated by opacity.
/// - kMip, kMinip, kAverage: the greatest, least or mean value along a ray, in the transfer function's colour for the
///   value. The ray goes through the middle of the part of the pixel that volume and clipping cover. If there is a
///   value other than NaN, alpha is the covered share; opacities, light and the opacity threshold are ignored. Values
///   are interpolated linearly on the level of the pixel lattice. Extrema are exact; means and kAttenuatedMip have
///   samples at most half a voxel of depth apart, kAttenuatedMip also where a ray crosses planes of voxels.
enum class Mode { kComposite, kMip, kMinip, kAverage, kAttenuatedMip };
inline constexpr std::array<std::string_view, 5> kModeNames = {"composite", "mip", "minip", "average",
                                                               "attenuated-mip"};
/// Attenuation of attenuated MIP by the greatest value, by default. unit: per voxel of level 0.
inline constexpr double kAttenuation = 0.05;

/// The light behind the volume: linear, premultiplied, in equal steps from the middle of the top pixel row to the
/// middle of the bottom row.
struct Background {
  std::array<double, 4> top{0, 0, 0, 0}, bottom{0, 0, 0, 0};
  bool operator==(const Background&) const = default;
};

enum class Aov { kDepth, kNormal, kValue };
/// Additional planes of 32-bit floats per pixel (arbitrary output variables), with the EXR names that compositing
/// programs expect. Colours are unaffected. Each part of the volume is weighted by its contribution to the pixel's
/// alpha; the background has no weight.
struct Aovs {
  /// Depth along the view direction, from the plane through the eye, in either projection: z of view space. unit:
  /// world.
  /// - "Z": depth at which the pixel's alpha passes one half, the nearest over its sub-pixels; +infinity if it does not
  ///   pass, so that a depth composite puts the pixel behind everything.
  /// - "depth.mean": mean depth of the pixel's contributions, over all sub-pixels; +infinity without contributions.
  bool depth = false;
  /// "N.X", "N.Y", "N.Z": mean of the shading normals (of the gradient or of the cutting face, turned towards the eye),
  /// in the world; unit length, or 0 without gradients.
  bool normal = false;
  /// "value", for the projecting modes: the projected value in the volume's units, the mean over the sub-pixels with a
  /// value; NaN without values.
  bool value = false;
  bool any() const { return depth || normal || value; }
  bool& of(Aov aov) { return aov == Aov::kDepth ? depth : aov == Aov::kNormal ? normal : value; }
  bool operator==(const Aovs&) const = default;
};

}  // namespace kiln
