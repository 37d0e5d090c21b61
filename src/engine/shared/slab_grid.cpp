#include "engine/shared/slab_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "grid/pyramid.h"

namespace kiln {
namespace {

// Limits of the slab thickness at the default sample distance; kThickest applies to small voxels. unit: pixels.
constexpr double kThinnest = 0.5, kThickest = 1;
// Least thickness for the finest sub-pixels, which may be larger than voxels. unit: pixels.
constexpr double kThinnestOfFinest = 0.25;
// Voxel edge from which slabs may be thicker than kThickest: there is no finer detail to miss. unit: pixels.
constexpr double kMagnified = 4;
// Voxel edge from which slabs are thinner fractions of a voxel: contours as wide as a slab would be seen as rings
// (engine/pixel/decisions/places.md). unit: pixels.
constexpr double kLargeVoxel = 16;
// Voxel edge of a coarser level from which a sample is a point. Below, a sample stands for all values that the voxel
// may hide (the kernel classifies an interval). unit: pixels.
constexpr double kPointEdge = 1;
constexpr int kZonesOfOctave = 8;

// Returns the slab thickness for a voxel edge. An edge in the picture has a rim as wide as a slab; the rim is visible
// if it is wider than a pixel and than a fraction of a voxel. unit: pixels.
double spacingFor(double edge_px, double distance) {
  const double magnified = edge_px < kLargeVoxel ? edge_px : std::sqrt(edge_px * kLargeVoxel);
  const double most = std::max(kThickest, magnified / kMagnified) * (distance / kSampleDistance);
  return std::min(edge_px * distance, most);
}

// Returns the least and the greatest depth of the volume, with whole voxel cubes.
std::array<double, 2> depthsOf(const VolumeGeometry& geometry, const View& view) {
  std::array<double, 2> out = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const glm::dvec3& corner : geometry.corners()) {
    const double z = (view.view_from_world * glm::dvec4(corner, 1)).z;
    out[0] = std::min(out[0], z);
    out[1] = std::max(out[1], z);
  }
  return out;
}

// Slabs of a parallel view that contain the depths [nearest, farthest], plus two slabs on either side. Slab borders are
// multiples of the thickness from the view's origin, which turns about the volume's centre (nearVolume). A turned view
// therefore keeps its sample positions and flickers least.
struct ParallelSlabs {
  double near;
  int count;
};
ParallelSlabs parallelSlabs(double nearest, double farthest, double thickness) {
  const double near = (std::floor(nearest / thickness) - 2) * thickness;
  return {near, static_cast<int>(std::ceil((farthest - near) / thickness)) + 2};
}

// Level and thickness at a scale of at most `scale` pixels per world unit.
SlabZone slabsAt(double scale, const ZonedVolume& zoned, std::optional<int> level) {
  const Manifest& volume = *zoned.manifest;
  SlabZone out;
  const int coarsest = static_cast<int>(volume.levels.size()) - 1;
  out.level = level ? *level : std::min(levelAtScale(volume, scale, zoned.finest) + zoned.coarser, coarsest);
  const double edge = volume.levels[static_cast<std::size_t>(out.level)].geometry.shortestEdge();
  const double of_picture = zoned.quincunx ? 0.5 * scale : scale;
  out.intervals = out.level > 0 && edge * scale < kPointEdge - 1e-9;
  const double thinnest = zoned.finest ? kThinnestOfFinest : kThinnest;
  out.thickness = std::max(thinnest, spacingFor(edge * of_picture, zoned.sample_distance)) / of_picture;
  return out;
}

struct ZoneSlabs {
  double near, far, thickness;
  int count;
};

// Slabs of about `thickness` that fill the depths [near, near + width). Zones of an eye far away are deeper than any
// volume: of more than kMostRaySlabs slabs only those about the volumes' depths are kept.
ZoneSlabs slabsOfZone(double near, double width, double thickness, const std::array<double, 2>& depths) {
  const double all = std::max(1.0, std::round(width / thickness));
  ZoneSlabs out{near, near + width, width / all, 0};
  double kept = all;
  if (all > kMostRaySlabs) {
    const auto slabAt = [&](double depth) { return std::clamp(std::floor((depth - near) / out.thickness), 0.0, all); };
    const double first = std::max(slabAt(depths[0]) - SlabZone::kOverlap, 0.0);
    const double end = std::min(slabAt(depths[1]) + SlabZone::kOverlap, all);
    out.near = near + first * out.thickness, out.far = near + end * out.thickness;
    kept = end - first;
  }
  out.count = static_cast<int>(std::min(kept, double{kMostRaySlabs}));
  if (kept > kMostRaySlabs) out.thickness = (out.far - out.near) / kMostRaySlabs;
  return out;
}

}  // namespace

std::vector<SlabZone> slabZones(const ZonedVolume& volume, const View& view, std::optional<int> level) {
  const std::array<double, 2> depths = depthsOf(volume.manifest->geometry(), view);
  if (view.projection == Projection::kOrthographic) {
    SlabZone zone = slabsAt(view.focal_px, volume, level);
    // parallelSlabs adds up to six slabs.
    zone.thickness = std::max(zone.thickness, (depths[1] - depths[0]) / (kMostRaySlabs - 6));
    const ParallelSlabs slabs = parallelSlabs(depths[0], depths[1], zone.thickness);
    zone.near = slabs.near;
    zone.slabs = slabs.count;
    zone.far = zone.near + zone.slabs * zone.thickness;
    return {zone};
  }
  std::vector<SlabZone> out;
  int exponent;
  std::frexp(volume.near_depth, &exponent);
  for (--exponent; std::ldexp(1.0, exponent) <= depths[1] * 1.1; ++exponent) {
    for (int eighth = 0; eighth < kZonesOfOctave; ++eighth) {
      const double width = std::ldexp(1.0, exponent) / kZonesOfOctave;
      const double near = std::ldexp(1.0, exponent) + eighth * width;
      if (near + width <= volume.near_depth || near > depths[1] * 1.1) continue;
      // Zones more than a quarter of their depth in front of the volume hold no samples. Does not apply to a given
      // level, whose voxels may have any size.
      if (!level && (near + width) * 1.25 < depths[0]) continue;
      SlabZone zone = slabsAt(view.focal_px / near, volume, level);
      const ZoneSlabs slabs = slabsOfZone(near, width, zone.thickness, depths);
      zone.near = slabs.near, zone.far = slabs.far;
      zone.slabs = slabs.count, zone.thickness = slabs.thickness;
      zone.behind_finer = !out.empty() && out.back().level < zone.level;
      out.push_back(zone);
    }
  }
  return out;
}

namespace {

struct Depths {
  double near, far;
};

// Depths that samples of each volume may have. unit: world, along the view.
std::vector<Depths> drawnDepths(std::span<const ZonedVolume> volumes, const View& view) {
  std::vector<Depths> out;
  for (const ZonedVolume& volume : volumes) {
    const std::array<double, 2> depths = depthsOf(volume.manifest->geometry(), view);
    const bool perspective = view.projection == Projection::kPerspective;
    out.push_back({perspective ? std::max(depths[0], volume.near_depth) : depths[0], depths[1]});
  }
  return out;
}

// Slabs of the volumes that reach into the depths [near, far), extended by two of their own slabs on either side. All
// have the thickness of the thinnest.
struct SharedSlabs {
  std::vector<SlabZone> volumes;
  std::vector<bool> reaches;
  double thickness = std::numeric_limits<double>::infinity();  // infinite if no volume reaches into the depths
};
SharedSlabs sharedSlabs(double scale, double near, double far, std::span<const ZonedVolume> volumes,
                        std::span<const Depths> depths, std::optional<int> level) {
  SharedSlabs out;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    out.volumes.push_back(slabsAt(scale, volumes[i], level));
    const double own = out.volumes.back().thickness, reach = 2 * own;
    out.reaches.push_back(depths[i].near <= depths[i].far && depths[i].near - reach < far &&
                          depths[i].far + reach >= near);
    if (out.reaches.back()) out.thickness = std::min(out.thickness, own);
  }
  return out;
}

// Appends [near, far) as zones of at most kMostSharedSlabs slabs.
void addShared(const SharedSlabs& shared, double near, double far, double thickness, int slabs,
               std::vector<std::vector<SlabZone>>& out) {
  const int parts = (slabs + kMostSharedSlabs - 1) / kMostSharedSlabs;
  for (int part = 0, first = 0; part < parts; ++part) {
    const int end = static_cast<int>(std::int64_t{slabs} * (part + 1) / parts);
    std::vector<SlabZone> zone = shared.volumes;
    for (std::size_t i = 0; i < zone.size(); ++i) {
      zone[i].near = near + first * thickness;
      zone[i].far = end == slabs ? far : near + end * thickness;
      zone[i].behind_finer = !out.empty() && out.back()[i].slabs > 0 && out.back()[i].level < zone[i].level;
      zone[i].thickness = thickness;
      zone[i].slabs = shared.reaches[i] ? end - first : 0;
    }
    out.push_back(std::move(zone));
    first = end;
  }
}

}  // namespace

std::vector<std::vector<SlabZone>> sharedZones(std::span<const ZonedVolume> volumes, const View& view,
                                               std::optional<int> level) {
  const std::vector<Depths> depths = drawnDepths(volumes, view);
  Depths all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Depths& d : depths) {
    if (d.near <= d.far) all = {std::min(all.near, d.near), std::max(all.far, d.far)};
  }
  std::vector<std::vector<SlabZone>> out;
  if (!(all.near <= all.far)) return out;
  if (view.projection == Projection::kOrthographic) {
    const SharedSlabs shared = sharedSlabs(view.focal_px, all.near, all.far, volumes, depths, level);
    const double thickness = std::max(shared.thickness, (all.far - all.near) / (kMostRaySlabs - 6));
    const ParallelSlabs slabs = parallelSlabs(all.near, all.far, thickness);
    addShared(shared, slabs.near, slabs.near + slabs.count * thickness, thickness, slabs.count, out);
    return out;
  }
  int exponent;
  std::frexp(all.near, &exponent);
  for (--exponent; std::ldexp(1.0, exponent) <= all.far * 1.1; ++exponent) {
    const double width = std::ldexp(1.0, exponent) / kZonesOfOctave;
    for (int eighth = 0; eighth < kZonesOfOctave; ++eighth) {
      const double near = std::ldexp(1.0, exponent) + eighth * width;
      const SharedSlabs shared = sharedSlabs(view.focal_px / near, near, near + width, volumes, depths, level);
      if (std::isinf(shared.thickness)) continue;
      const ZoneSlabs slabs = slabsOfZone(near, width, shared.thickness, {all.near, all.far});
      addShared(shared, slabs.near, slabs.far, slabs.thickness, slabs.count, out);
    }
  }
  return out;
}

}  // namespace kiln
