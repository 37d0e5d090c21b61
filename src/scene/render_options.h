// Choices that engines and jobs share: occlusion tests, sample lattice, projection of values, background, extra planes.
#pragma once

#include <array>
#include <cstddef>

namespace kiln {

enum class VisibilityMethod { kNone, kMask, kRangeTree, kQuadtree, kOverlay };
/// The rectangle that stands for a node of the octree: around its projected box and the footprint, or around the
/// projection of its circumscribed sphere (Lee and Ihm §2.2.3).
enum class ProjectedArea { kBox, kSphere };

inline constexpr int kLargestEpsilon = 65536;

/// How hidden nodes are found.
struct VisibilityOptions {
  VisibilityMethod method = VisibilityMethod::kMask;
  ProjectedArea area = ProjectedArea::kBox;
  int epsilon_px = 0;  // kQuadtree: projected areas are enlarged by this on every side, at most kLargestEpsilon
  /// Samples whose own footprints lie on closed pixels are left out before they are shaded; the tile's pixels say it,
  /// whatever the method. Lee and Ihm ask for nodes only, and so it is with the quadtree.
  bool test_samples = true;
  bool operator==(const VisibilityOptions&) const = default;
};
/// Where samples are (engine/pixel/decisions/samples.md).
/// - kPixel: where rays through pixels meet slabs, each in its pixel alone.
/// - kVoxel: the voxels, as Lee and Ihm splat them.
enum class Lattice { kPixel, kVoxel };
/// The lattice that a word of kLatticeNames names: "ray" is another name of the first.
constexpr Lattice latticeOfName(std::size_t word) { return word == 1 ? Lattice::kVoxel : Lattice::kPixel; }

/// What a pixel shows of what is behind it.
/// - kComposite: light that the volume sends, as opacity lets it through.
/// - kMip, kMinip, kAverage: the greatest, the least or the mean value along the ray through the pixel's centre, in the
///   volume and the clipping, in the colour that the transfer function has for it. The pixel is opaque where there is
///   such a value, NaN being none; opacities, light and the opacity threshold say nothing. Values are interpolated
///   linearly, at most a pixel and half a voxel apart in depth, of the level that the pixel lattice has there.
enum class Mode { kComposite, kMip, kMinip, kAverage };

/// What is behind the volume: linear light, premultiplied, from the middle of the top row of pixels to that of the
/// bottom row in equal steps.
struct Background {
  std::array<double, 4> top{0, 0, 0, 0}, bottom{0, 0, 0, 0};
  bool operator==(const Background&) const = default;
};

enum class Aov { kDepth, kNormal, kValue };
/// What a picture tells of each pixel beside its colour (arbitrary output variables), as planes of 32-bit floats that
/// are named as compositing programs expect them in an EXR. The colours are the same with and without. Every part of
/// the volume counts as much as it adds to the pixel's alpha, and the background not at all.
struct Aovs {
  /// Depth along the direction of view, from the plane through the eye, in either projection: z of view space. unit:
  /// world.
  /// "Z": where the pixel's alpha passes one half; the nearest of its sub-pixels'. +infinity where it does not, which
  /// is behind everything, whatever a depth composite lays over it. "depth.mean": the mean of all that the pixel shows,
  /// of all its sub-pixels; +infinity where it shows nothing.
  bool depth = false;
  /// "N.X", "N.Y", "N.Z": the mean of the normals that light falls on (of the gradient or the face that cuts, turned
  /// towards the eye), in the world; of unit length, or 0 where nothing shown has a gradient.
  bool normal = false;
  /// "value", of the modes that project one: itself, in the volume's units; the mean of those of a pixel's sub-pixels
  /// that have one; NaN where there is none.
  bool value = false;
  bool any() const { return depth || normal || value; }
  bool& of(Aov aov) { return aov == Aov::kDepth ? depth : aov == Aov::kNormal ? normal : value; }
  bool operator==(const Aovs&) const = default;
};

}  // namespace kiln
