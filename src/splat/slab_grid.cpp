#include "splat/slab_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "grid/pyramid.h"

namespace kiln {
namespace {

// The least and the largest spacing of samples. unit: pixels.
constexpr double kLeastSpacing = 0.5, kMostSpacing = 0.75, kMagnifiedSpacing = 1;
// From which edge of a voxel on they may be farther apart: there is no detail left that they could miss. unit: pixels.
constexpr double kMagnified = 4;
// Where a transfer function is not steeper than this, what is between two samples is nearly their mean: they are as
// large a part of a voxel apart, up to a pixel (ARCHITECTURE.md has the figures). With whole voxels a head's brightness
// is off by more than 1 %.
constexpr double kSoft = 1, kSoftSpacing = 8.0 / 11;
// Samples that are farther apart than by default may be as much farther apart in the picture. unit: pixels a voxel.
constexpr double kSpacingPerDistance = 0.6;

// Nearer where nearer samples are asked for: half as far apart is a pixel at the most no more, but half of one.
double softSpacing(double edge_px, double distance) {
  const double nearer = std::min(distance / kSampleDistance, 1.0);
  return std::clamp(edge_px * kSoftSpacing * nearer, kLeastSpacing, kMagnifiedSpacing * nearer);
}
static_assert(kMagnifiedSpacing * kLeastSampleDistance / kSampleDistance >= kLeastSpacing);

// How far samples are apart of voxels that are so large: by default half a voxel, as what lies between voxels has
// detail of that size (ARCHITECTURE.md has the figures). `distance`: Sampling's. unit: pixels.
double spacingFor(double edge_px, double steepness, double distance) {
  const double most =
      (kMostSpacing + kSpacingPerDistance * (distance - kSampleDistance)) * std::max(edge_px / kMagnified, 1.0);
  const double own = std::clamp(edge_px * distance, kLeastSpacing, std::min(most, kMagnifiedSpacing));
  return steepness <= kSoft ? std::max(own, softSpacing(edge_px, distance)) : own;
}
// On rays there is a rim as wide as a step round each slope where it begins, which shows where it is wider than a pixel
// and than a part of a voxel. unit: pixels.
double raySpacingFor(double edge_px, double distance) {
  const double most = std::max(kMagnifiedSpacing, edge_px / kMagnified) * (distance / kSampleDistance);
  return std::min(edge_px * distance, most);
}
// From which spacing on a coarser level's voxels are refined: below, each stands for all values that it may hide (the
// interval that the sweep classifies), which a refined sample does not. unit: pixels.
constexpr double kCoarseSpacing = 1;
// A footprint is a pixel's square folded with a Gaussian of this deviation, in spacings. Narrower is sharper by some
// tenths of a decibel, and flickers where voxels are smaller than pixels.
constexpr double kSigma = 0.42;
// That of soft voxels, at most: it needs no more pixels than others. unit: pixels.
constexpr double kSoftSigma = 0.36;
// Soft voxels have samples of their own where these are at most this part of what they would have.
constexpr double kWorthIt = 0.6;
// Slabs are as thick as samples are apart: what is behind in a slab shows through what is in front. unit: pixels.
constexpr double kThinnest = 0.5;
// A lattice finer than half a pixel, where there is no coarser level, is smoothed no less than this. unit: pixels.
constexpr double kLeastSigma = 0.15;
// How much a pixel at an edge covers less where samples are refined, which are no thinner than the detail between them:
// one sample a voxel has none, two some, three and more the most.
constexpr float kErosion = 0.0625f, kMostErosion = 0.25f;
constexpr int kZonesOfOctave = 8;

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
// slabs are multiples of the thickness from the origin of the world, so that they do not depend on what is in view.
struct ParallelSlabs {
  double near;
  int count;
};
ParallelSlabs parallelSlabs(const View& view, double nearest, double farthest, double thickness) {
  const double origin = view.view_from_world[3].z;
  const double near = origin + (std::floor((nearest - origin) / thickness) - 2) * thickness;
  return {near, static_cast<int>(std::ceil((farthest - near) / thickness)) + 2};
}

// As many as it takes; but whole parts of a voxel where these are nearly as large, as between them nothing beats
// against the voxels.
Refinement refinementFor(double edge_px, double spacing_px) {
  constexpr double kMost = kRefinedVoxels * kLargestRefinement;
  const double samples = std::ceil(kRefinedVoxels * edge_px / spacing_px - 1e-9);
  Refinement out{static_cast<int>(std::clamp(samples, double{kRefinedVoxels}, kMost))};
  if (out.samples == kRefinedVoxels + 1) --out.samples;
  if (out.samples == 2 * kRefinedVoxels - 1) ++out.samples;
  while (!unitHasRoom(out, 1)) ++out.samples;
  return out;
}

// The next number of samples of which a block (softBlock) has a whole number.
Refinement wholeInBlocks(Refinement refinement, int block) {
  const int of_block = kRefinedVoxels / block;
  refinement.samples = (refinement.samples + of_block - 1) / of_block * of_block;
  return refinement;
}

// Samples of soft voxels, where they are fewer by enough.
void setSoft(const ZonedVolume& zoned, const glm::dvec3& edges_px, SlabZone& zone) {
  zone.soft_refinement = zone.refinement;
  zone.soft_sigma_px = zone.sigma_px;
  if (zoned.soft == SoftSamples::kNever || !zone.refined()) return;
  const double wanted = softSpacing(std::min({edges_px.x, edges_px.y, edges_px.z}), zoned.sample_distance);
  std::array<Refinement, 3> own, soft;
  double widest = 0, part = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int block = softBlock(zone.refinement[a]);
    own[a] = wholeInBlocks(zone.refinement[a], block);
    soft[a] = wholeInBlocks(refinementFor(edges_px[axis], wanted), block);
    if (soft[a].samples > own[a].samples) return;
    widest = std::max(widest, edges_px[axis] / soft[a].ofVoxel());
    part *= soft[a].ofVoxel() / zone.refinement[a].ofVoxel();
  }
  if (part > kWorthIt || (zoned.soft == SoftSamples::kWhereFree && own != zone.refinement)) return;
  zone.refinement = own;
  zone.soft_refinement = soft;
  zone.soft_sigma_px = std::max(zone.sigma_px, std::min(kSigma * widest, kSoftSigma));
}

// Level, refinement and footprint where a world length of 1 is at most `scale` pixels.
SlabZone latticeAt(double scale, const ZonedVolume& zoned, std::optional<int> level) {
  const Manifest& volume = *zoned.manifest;
  SlabZone out;
  out.level = level ? *level : levelAtScale(volume, scale);
  const VolumeGeometry& drawn = volume.levels[static_cast<std::size_t>(out.level)].geometry;
  const glm::dvec3 spacing = drawn.spacing();
  // A voxel of a coarser level is as much thicker.
  const double steepness = zoned.steepness * drawn.meanSpacing() / volume.geometry().meanSpacing();
  if (zoned.on_rays) {
    out.on_rays = true;
    const double of_picture = zoned.quincunx ? 0.5 * scale : scale;
    out.intervals = out.level > 0 && drawn.shortestEdge() * scale < kCoarseSpacing - 1e-9;
    out.thickness =
        std::max(kThinnest, raySpacingFor(drawn.shortestEdge() * of_picture, zoned.sample_distance)) / of_picture;
    return out;
  }
  const double wanted = spacingFor(drawn.shortestEdge() * scale, steepness, zoned.sample_distance);
  double widest = 0, least_refined = kLargestRefinement;
  for (int axis = 0; axis < 3; ++axis) {
    const double edge = spacing[axis] * scale;
    Refinement& refinement = out.refinement[static_cast<std::size_t>(axis)];
    if (out.level == 0 || edge >= kCoarseSpacing - 1e-9) refinement = refinementFor(edge, wanted);
    widest = std::max(widest, edge / refinement.ofVoxel());
    least_refined = std::min(least_refined, refinement.ofVoxel());
  }
  out.intervals = out.level > 0 && !out.refined();
  out.sigma_px = std::max(kSigma * widest, kLeastSigma);
  setSoft(zoned, spacing * scale, out);
  const double beside = least_refined - 1;
  out.erosion = std::min(kErosion * static_cast<float>(beside * beside * beside), kMostErosion);
  out.thickness = std::max(kThinnest, widest) / scale;
  return out;
}

}  // namespace

int softBlock(const Refinement& refinement) {
  int voxels = kMostSoftBlock;
  while (!unitHasRoom(refinement, voxels)) voxels /= 2;
  return voxels;
}

std::vector<SlabZone> slabZones(const ZonedVolume& volume, const View& view, std::optional<int> level) {
  const std::array<double, 2> depths = depthsOf(volume.manifest->geometry(), view);
  if (view.projection == Projection::kOrthographic) {
    SlabZone zone = latticeAt(view.focal_px, volume, level);
    // Up to six more are beside it.
    if (zone.on_rays) zone.thickness = std::max(zone.thickness, (depths[1] - depths[0]) / (kMostRaySlabs - 6));
    const ParallelSlabs slabs = parallelSlabs(view, depths[0], depths[1], zone.thickness);
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
      SlabZone zone = latticeAt(view.focal_px / near, volume, level);
      zone.near = near;
      zone.far = near + width;
      // About as thick as a pixel is wide in the middle of the zone.
      const double wanted = (zone.on_rays ? 1 : (near + 0.5 * width) / near) * zone.thickness;
      const double slabs = std::min(width / wanted, zone.on_rays ? double{kMostRaySlabs} : 1e9);
      zone.slabs = std::max(1, static_cast<int>(std::lround(slabs)));
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

// The lattices of the volumes that reach into depths [near, far), a slab of theirs more on either side; their slabs are
// as thick as the thickest, on rays as the thinnest.
struct SharedLattice {
  std::vector<SlabZone> volumes;
  std::vector<bool> reaches;
  double thickness = 0;  // 0 where no volume reaches
};
SharedLattice sharedLattice(double scale, double near, double far, std::span<const ZonedVolume> volumes,
                            std::span<const Depths> depths, std::optional<int> level) {
  SharedLattice out;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    out.volumes.push_back(latticeAt(scale, volumes[i], level));
    const double reach = 2 * out.volumes.back().thickness;
    out.reaches.push_back(depths[i].near <= depths[i].far && depths[i].near - reach < far &&
                          depths[i].far + reach >= near);
    if (!out.reaches.back()) continue;
    const double own = out.volumes.back().thickness;
    if (out.thickness == 0)
      out.thickness = own;
    else
      out.thickness = volumes[i].on_rays ? std::min(out.thickness, own) : std::max(out.thickness, own);
  }
  return out;
}

// Appends [near, near + slabs · thickness) as zones of at most kMostSharedSlabs.
void addShared(const SharedLattice& lattice, double near, double thickness, int slabs,
               std::vector<std::vector<SlabZone>>& out) {
  const int parts = (slabs + kMostSharedSlabs - 1) / kMostSharedSlabs;
  for (int part = 0, first = 0; part < parts; ++part) {
    const int end = static_cast<int>(std::int64_t{slabs} * (part + 1) / parts);
    std::vector<SlabZone>& zone = out.emplace_back(lattice.volumes);
    for (std::size_t i = 0; i < zone.size(); ++i) {
      zone[i].near = near + first * thickness;
      zone[i].far = near + end * thickness;
      zone[i].thickness = thickness;
      zone[i].slabs = lattice.reaches[i] ? end - first : 0;
    }
    first = end;
  }
}

}  // namespace

std::vector<std::vector<SlabZone>> sharedZones(std::span<const ZonedVolume> volumes, const View& view,
                                               std::optional<int> level) {
  const std::vector<Depths> depths = drawnDepths(volumes, view);
  // Slabs are as thick as the thickest: a soft volume must not widen those of a steep one.
  std::vector<ZonedVolume> alike(volumes.begin(), volumes.end());
  double steepest = 0;
  for (const ZonedVolume& volume : alike) steepest = std::max(steepest, volume.steepness);
  for (ZonedVolume& volume : alike) volume.steepness = steepest;
  Depths all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Depths& d : depths) {
    if (d.near <= d.far) all = {std::min(all.near, d.near), std::max(all.far, d.far)};
  }
  std::vector<std::vector<SlabZone>> out;
  if (!(all.near <= all.far)) return out;
  if (view.projection == Projection::kOrthographic) {
    const SharedLattice lattice = sharedLattice(view.focal_px, all.near, all.far, alike, depths, level);
    double t = lattice.thickness;
    if (alike.front().on_rays) t = std::max(t, (all.far - all.near) / (kMostRaySlabs - 6));
    const ParallelSlabs slabs = parallelSlabs(view, all.near, all.far, t);
    addShared(lattice, slabs.near, t, slabs.count, out);
    return out;
  }
  int exponent;
  std::frexp(all.near, &exponent);
  for (--exponent; std::ldexp(1.0, exponent) <= all.far * 1.1; ++exponent) {
    const double width = std::ldexp(1.0, exponent) / kZonesOfOctave;
    for (int eighth = 0; eighth < kZonesOfOctave; ++eighth) {
      const double near = std::ldexp(1.0, exponent) + eighth * width;
      const SharedLattice lattice = sharedLattice(view.focal_px / near, near, near + width, alike, depths, level);
      if (lattice.thickness == 0) continue;
      // As in slabZones.
      const bool rays = alike.front().on_rays;
      const double wanted = (rays ? 1 : (near + 0.5 * width) / near) * lattice.thickness;
      const double most = rays ? double{kMostRaySlabs} : 1e9;
      const int slabs = std::max(1, static_cast<int>(std::lround(std::min(width / wanted, most))));
      addShared(lattice, near, width / slabs, slabs, out);
    }
  }
  return out;
}

}  // namespace kiln
