#include "engine/shared/slab_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grid/pyramid.h"

namespace kiln {
namespace {

// Slabs are no thinner, and by default no thicker where voxels are small. unit: pixels.
constexpr double kThinnest = 0.5, kThickest = 1;
// The same of the smallest sub-pixels, which may be larger than voxels.
constexpr double kThinnestOfFinest = 0.25;
// From which edge of a voxel on they may be thicker: there is no detail left that they could miss. unit: pixels.
constexpr double kMagnified = 4;
// From which edge of a coarser level's voxel on a sample is a point: below, it stands for all values that the voxel may
// hide (the interval that the kernel classifies). unit: pixels.
constexpr double kPointEdge = 1;
constexpr int kZonesOfOctave = 8;

// Around each slope there is a rim as wide as a slab, which shows where it is wider than a pixel and than a part of a
// voxel. unit: pixels.
double spacingFor(double edge_px, double distance) {
  const double most = std::max(kThickest, edge_px / kMagnified) * (distance / kSampleDistance);
  return std::min(edge_px * distance, most);
}

// Depths that the volume spans, its voxels' cubes included.
std::array<double, 2> depthsOf(const VolumeGeometry& geometry, const View& view) {
  std::array<double, 2> out = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const glm::dvec3& corner : geometry.corners()) {
    const double z = (view.view_from_world * glm::dvec4(corner, 1)).z;
    out[0] = std::min(out[0], z);
    out[1] = std::max(out[1], z);
  }
  return out;
}

// Slabs of a parallel view that hold the depths from `nearest` to `farthest`, two more in front and behind. Borders of
// slabs are multiples of the thickness from the view's origin, which turns about the volume's centre (nearVolume): so a
// turned picture has its samples where the one before had them, and flickers least.
struct ParallelSlabs {
  double near;
  int count;
};
ParallelSlabs parallelSlabs(double nearest, double farthest, double thickness) {
  const double near = (std::floor(nearest / thickness) - 2) * thickness;
  return {near, static_cast<int>(std::ceil((farthest - near) / thickness)) + 2};
}

// Level and thickness where a world length of 1 is at most `scale` pixels.
SlabZone slabsAt(double scale, const ZonedVolume& zoned, std::optional<int> level) {
  const Manifest& volume = *zoned.manifest;
  SlabZone out;
  out.level = level ? *level : levelAtScale(volume, scale, zoned.finest);
  const double edge = volume.levels[static_cast<std::size_t>(out.level)].geometry.shortestEdge();
  const double of_picture = zoned.quincunx ? 0.5 * scale : scale;
  out.intervals = out.level > 0 && edge * scale < kPointEdge - 1e-9;
  const double thinnest = zoned.finest ? kThinnestOfFinest : kThinnest;
  out.thickness = std::max(thinnest, spacingFor(edge * of_picture, zoned.sample_distance)) / of_picture;
  return out;
}

// As many slabs of about this thickness as fill a zone.
int slabsIn(double width, double thickness) {
  return std::max(1, static_cast<int>(std::lround(std::min(width / thickness, double{kMostRaySlabs}))));
}

}  // namespace

std::vector<SlabZone> slabZones(const ZonedVolume& volume, const View& view, std::optional<int> level) {
  const std::array<double, 2> depths = depthsOf(volume.manifest->geometry(), view);
  if (view.projection == Projection::kOrthographic) {
    SlabZone zone = slabsAt(view.focal_px, volume, level);
    // Up to six more are beside it.
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
      // In front of the volume by more than slabs reach. (A level that is asked for may have voxels of any size.)
      if (!level && (near + width) * 1.25 < depths[0]) continue;
      SlabZone zone = slabsAt(view.focal_px / near, volume, level);
      zone.near = near;
      zone.far = near + width;
      zone.slabs = slabsIn(width, zone.thickness);
      zone.thickness = width / zone.slabs;
      out.push_back(zone);
    }
  }
  return out;
}

namespace {

struct Depths {
  double near, far;
};

// Where the volumes' samples may be. unit: world, along the view.
std::vector<Depths> drawnDepths(std::span<const ZonedVolume> volumes, const View& view) {
  std::vector<Depths> out;
  for (const ZonedVolume& volume : volumes) {
    const std::array<double, 2> depths = depthsOf(volume.manifest->geometry(), view);
    const bool perspective = view.projection == Projection::kPerspective;
    out.push_back({perspective ? std::max(depths[0], volume.near_depth) : depths[0], depths[1]});
  }
  return out;
}

// The slabs of the volumes that reach into depths [near, far), a slab of theirs more on either side; they are as thick
// as the thinnest.
struct SharedSlabs {
  std::vector<SlabZone> volumes;
  std::vector<bool> reaches;
  double thickness = std::numeric_limits<double>::infinity();  // infinite where no volume reaches
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

// Appends [near, near + slabs · thickness) as zones of at most kMostSharedSlabs.
void addShared(const SharedSlabs& shared, double near, double thickness, int slabs,
               std::vector<std::vector<SlabZone>>& out) {
  const int parts = (slabs + kMostSharedSlabs - 1) / kMostSharedSlabs;
  for (int part = 0, first = 0; part < parts; ++part) {
    const int end = static_cast<int>(std::int64_t{slabs} * (part + 1) / parts);
    std::vector<SlabZone>& zone = out.emplace_back(shared.volumes);
    for (std::size_t i = 0; i < zone.size(); ++i) {
      zone[i].near = near + first * thickness;
      zone[i].far = near + end * thickness;
      zone[i].thickness = thickness;
      zone[i].slabs = shared.reaches[i] ? end - first : 0;
    }
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
    addShared(shared, slabs.near, thickness, slabs.count, out);
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
      const int slabs = slabsIn(width, shared.thickness);
      addShared(shared, near, width / slabs, slabs, out);
    }
  }
  return out;
}

}  // namespace kiln
