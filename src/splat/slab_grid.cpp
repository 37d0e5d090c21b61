#include "splat/slab_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "grid/pyramid.h"

namespace kiln {
namespace {

// The largest spacing of samples: what a picture at a pixel a voxel needs to be no worse than a ray caster's
// (ARCHITECTURE.md has the figures). unit: pixels.
constexpr double kSpacing = 0.75;
// From which spacing on a coarser level's voxels are refined: below, each stands for all values that it may hide (the
// interval that the sweep classifies), which a refined sample does not. unit: pixels.
constexpr double kCoarseSpacing = 1;
// A footprint is a pixel's square folded with a Gaussian of this deviation, in spacings. Narrower is sharper by some
// tenths of a decibel, and flickers where voxels are smaller than pixels.
constexpr double kSigma = 0.42;
// Slabs are as thick as samples are apart: what is behind in a slab shows through what is in front. unit: pixels.
constexpr double kThinnest = 0.5;
// A lattice finer than half a pixel, where there is no coarser level, is smoothed no less than this. unit: pixels.
constexpr double kLeastSigma = 0.15;
// How much a pixel at an edge covers less where samples are refined, which are no thinner than the detail between them:
// one sample a voxel has none, two some, three and more the most.
constexpr float kErosion = 0.0625f, kMostErosion = 0.25f;
constexpr int kZonesOfOctave = 8;

double shortest(const VolumeGeometry& geometry) {
  const glm::dvec3 s = geometry.spacing();
  return std::min({s.x, s.y, s.z});
}

// Depths that the volume spans, its voxels' cubes included.
std::array<double, 2> depthsOf(const VolumeGeometry& geometry, const View& view) {
  const glm::dmat4 view_from_index = view.view_from_world * geometry.world_from_index;
  std::array<double, 2> out = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (int corner = 0; corner < 8; ++corner) {
    glm::dvec4 p(0, 0, 0, 1);
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = (corner >> axis & 1) != 0 ? static_cast<double>(geometry.dims[axis]) - 0.5 : -0.5;
    const double z = (view_from_index * p).z;
    out[0] = std::min(out[0], z);
    out[1] = std::max(out[1], z);
  }
  return out;
}

// Level, refinement and footprint where a world length of 1 is at most `scale` pixels.
SlabZone latticeAt(double scale, const Manifest& volume, std::optional<int> level) {
  SlabZone out;
  out.level = level.value_or(0);
  if (!level) {
    const int last = static_cast<int>(volume.levels.size()) - 1;
    while (out.level < last &&
           shortest(volume.levels[static_cast<std::size_t>(out.level) + 1].geometry) * scale <= 1 - 1e-9)
      ++out.level;
  }
  const glm::dvec3 spacing = volume.levels[static_cast<std::size_t>(out.level)].geometry.spacing();
  double widest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double edge = spacing[axis] * scale;
    const bool whole = out.level > 0 && edge < kCoarseSpacing - 1e-9;
    int n = whole ? 1 : static_cast<int>(std::ceil(edge / kSpacing - 1e-9));
    n = std::min(n, kLargestRefinement);
    out.refinement[static_cast<std::size_t>(axis)] = n;
    widest = std::max(widest, edge / n);
  }
  out.sigma_px = std::max(kSigma * widest, kLeastSigma);
  const int beside = *std::min_element(out.refinement.begin(), out.refinement.end()) - 1;
  out.erosion = std::min(kErosion * static_cast<float>(beside * beside), kMostErosion);
  out.thickness = std::max(kThinnest, widest) / scale;
  return out;
}

}  // namespace

std::vector<SlabZone> slabZones(const Manifest& volume, const View& view, std::optional<int> level, double near_depth) {
  const std::array<double, 2> depths = depthsOf(volume.geometry(), view);
  if (view.projection == Projection::kOrthographic) {
    SlabZone zone = latticeAt(view.focal_px, volume, level);
    zone.near = (std::floor(depths[0] / zone.thickness) - 2) * zone.thickness;
    zone.slabs = static_cast<int>(std::ceil((depths[1] - zone.near) / zone.thickness)) + 2;
    zone.far = zone.near + zone.slabs * zone.thickness;
    return {zone};
  }
  std::vector<SlabZone> out;
  int exponent;
  std::frexp(near_depth, &exponent);
  for (--exponent; std::ldexp(1.0, exponent) <= depths[1] * 1.1; ++exponent) {
    for (int eighth = 0; eighth < kZonesOfOctave; ++eighth) {
      const double width = std::ldexp(1.0, exponent) / kZonesOfOctave;
      const double near = std::ldexp(1.0, exponent) + eighth * width;
      if (near + width <= near_depth || near > depths[1] * 1.1) continue;
      // In front of the volume by more than slabs reach. (A level that is asked for may have voxels of any size.)
      if (!level && (near + width) * 1.25 < depths[0]) continue;
      SlabZone zone = latticeAt(view.focal_px / near, volume, level);
      zone.near = near;
      zone.far = near + width;
      // About as thick as a pixel is wide in the middle of the zone.
      const double wanted = zone.thickness * (near + 0.5 * width) / near;
      zone.slabs = std::max(1, static_cast<int>(std::lround(width / wanted)));
      zone.thickness = width / zone.slabs;
      out.push_back(zone);
    }
  }
  return out;
}

}  // namespace kiln
