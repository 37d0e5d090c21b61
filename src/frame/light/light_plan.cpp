#include "frame/light/light_plan.h"

#include <algorithm>
#include <cmath>

#include "engine/capabilities.h"
#include "frame/pass/make_visibility.h"
#include "grid/point_bounds.h"
#include "scene/camera/framing.h"

namespace kiln {
namespace {

// Smallest edge of a shadow map by default: a small picture of a large object has fine shadows, too. unit: pixels.
constexpr int kLeastMapEdge = 512;
// Pixels of a shadow map along a voxel's edge, at most. With one, borders of shadows on smooth surfaces are combs.
constexpr int kMapPixelsOfVoxel = 2;
// Rays along the longest edge of the lattice for ambient occlusion.
constexpr int kLatticeEdge = 256 * kRaysOfCell;
// Default radius of ambient occlusion. unit: longest edges of the volumes.
constexpr double kOcclusionRadius = 0.1;

std::vector<Clipping> clippingsOf(const FrameRequest& request) {
  std::vector<Clipping> out;
  for (const VolumeRequest& volume : request.volumes) out.push_back(volume.clipping);
  if (out.empty()) out.push_back(request.clipping);
  for (Clipping& clipping : out) clipping.part.reset();
  return out;
}

// Returns whether a transfer function of the picture has a property.
template <class Has>
bool anyFunction(const FrameRequest& request, const Has& has) {
  if (request.volumes.empty()) return has(request.transfer_function);
  return std::any_of(request.volumes.begin(), request.volumes.end(),
                     [&](const VolumeRequest& volume) { return has(volume.transfer_function); });
}

bool hasSurfaces(const FrameRequest& request) {
  return anyFunction(request, [](const TransferFunction& function) { return !function.surfaces.empty(); });
}

// Returns whether samples of a volume reflect or scatter light.
bool hasLight(const FrameRequest& request) {
  return anyFunction(request, [](const TransferFunction& function) { return function.shaded || function.scattering; });
}

}  // namespace

ShownExtent shownExtentOf(const std::vector<const BrickedVolume*>& volumes, const std::vector<Clipping>& clippings) {
  ShownExtent out;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const VolumeGeometry whole = volumes[i]->manifest().geometry();
    VoxelBox box = boxOf(whole.dims);
    if (clippings[i].region) box = intersection(box, *clippings[i].region);
    if (box.empty()) continue;
    const VolumeGeometry shown = partOf(whole, box);
    for (const glm::dvec3& corner : shown.corners()) out.corners.push_back(corner);
    out.longest = std::max({out.longest, shown.dims.x, shown.dims.y, shown.dims.z});
    const double voxel = whole.meanSpacing();
    out.voxel = out.voxel > 0 ? std::min(out.voxel, voxel) : voxel;
  }
  return out;
}

ShadowScene shadowSceneOf(const FrameRequest& request) {
  ShadowScene out;
  for (const VolumeRequest& volume : request.volumes) out.functions.push_back(volume.transfer_function);
  if (out.functions.empty()) out.functions.push_back(request.transfer_function);
  out.clippings = clippingsOf(request);
  out.level = request.level;
  out.coarser = request.coarser;
  out.interpolation = request.interpolation;
  out.sample_distance = request.sample_distance;
  out.opacity_threshold = request.opacity_threshold;
  return out;
}

bool isIlluminated(const FrameRequest& request) {
  return hasLight(request) && request.engine().capabilities().composites && isShaded(request.shading);
}

int shadowEdgeOf(const Light& light, const ShownExtent& extent, const ImageSize& picture) {
  if (light.shadow.resolution > 0) return std::max(light.shadow.resolution, kLeastShadowEdge);
  const int side = std::clamp(std::max(picture.width, picture.height), kLeastMapEdge, kShadowEdge);
  const auto edge = static_cast<int>(std::min<std::int64_t>(side, kMapPixelsOfVoxel * extent.longest));
  // A penumbra needs fewer pixels, and each of its lights a map.
  return std::max(light.shadow.softness > 0 ? edge / 2 : edge, kLeastShadowEdge);
}

std::vector<std::vector<ShadowView>> shadowMapViews(const Light& light, const View& eye, const ShownExtent& extent,
                                                    int edge_px) {
  glm::dvec3 centre(0);
  for (const glm::dvec3& corner : extent.corners) centre += corner / static_cast<double>(extent.corners.size());
  std::vector<std::vector<ShadowView>> out;
  for (const Light& point : pointsOf(light, eye, centre)) out.push_back(shadowViews(point, extent.corners, edge_px));
  return out;
}

FrameRequest opacityRequest(FrameRequest request, const View& view) {
  request.view = view;
  request.eyes.clear();
  request.shading.phong = false;
  // Cut faces are without light, and stop none.
  const auto without = [](Clipping& clipping) { clipping.part.reset(), clipping.section.reset(); };
  without(request.clipping);
  for (VolumeRequest& volume : request.volumes) volume.shading.phong = false, without(volume.clipping);
  const EngineChoice default_engine;
  request.lattice = default_engine.lattice;
  request.mode = default_engine.mode;
  request.crop.reset();
  request.samples = 1;
  request.filters_rays = false;
  request.aovs = {};
  request.deep.reset();
  request.visibility = {};
  request.tile_px = kSquareEdge;
  request.node_log = nullptr;
  return request;
}

LatticeView ambientLattice(const VolumeGeometry& first, const ShownExtent& extent) {
  Light along;
  along.kind = LightKind::kDirectional;
  along.place = -glm::dmat3(first.world_from_index)[2];
  const auto viewWith = [&](int edge) { return shadowViews(along, extent.corners, edge).front(); };
  ShadowView seen = viewWith(kLatticeEdge);
  const double depth = seen.depths.far - seen.depths.near;
  // The longest of the three edges has kLatticeEdge rays, or a ray each voxel.
  const double ray = std::max({pixelEdge(seen), depth / kLatticeEdge, extent.voxel});
  const double plane = std::max(seen.view.size.width, seen.view.size.height) * pixelEdge(seen);
  seen = viewWith(std::max(static_cast<int>(std::ceil(plane / ray)), 8));
  const int rays = static_cast<int>(std::ceil(depth / pixelEdge(seen)));
  return {seen.view, seen.depths.near, std::clamp(rays, 1, 2 * kLatticeEdge)};
}

double ambientRadius(const AmbientOcclusion& occlusion, const ShownExtent& extent) {
  if (occlusion.radius > 0) {
    PointBounds world;
    for (const glm::dvec3& corner : extent.corners) world.add(corner);
    return std::min(occlusion.radius, glm::distance(world.lo, world.hi));
  }
  return kOcclusionRadius * static_cast<double>(extent.longest) * extent.voxel;
}

std::uint64_t illuminationBytes(const std::vector<const BrickedVolume*>& volumes,
                                const std::vector<Clipping>& clippings, const Shading& shading, bool lights_move,
                                const ImageSize& picture) {
  const ShownExtent extent = shownExtentOf(volumes, clippings);
  if (extent.corners.empty() || !shading.phong) return 0;
  const auto bandBytes = [](int width, int height) {
    const int rows = std::min(height, kOpacityBand);
    return 4 * sizeof(float) * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(rows) +
           visibilityBytes(VisibilityMethod::kMask, {width, rows});
  };
  std::uint64_t kept = 0, drawing = 0;
  for (const Light& light : shading.lights) {
    if (!castsShadows(shading, light)) continue;
    const int edge = shadowEdgeOf(light, extent, picture);
    // A light that moves may enter the volume. The views of a far light have equal bounds for all directions.
    const bool approaches = lights_move && !isFar(light.kind);
    std::size_t maps = 0;
    for (const std::vector<ShadowView>& point : shadowMapViews(light, View(), extent, edge))
      maps += approaches ? kMostShadowViews : point.size();
    const std::uint64_t finished = DeepShadowMap::bytesFor(edge, edge, false);
    kept += maps * finished;
    drawing = std::max(drawing, DeepShadowMap::bytesFor(edge, edge, true) - finished + bandBytes(edge, edge));
  }
  if (shading.occlusion.strength > 0) {
    const LatticeView lattice = ambientLattice(volumes.front()->manifest().geometry(), extent);
    kept += ambientBytes(lattice) + bandBytes(lattice.view.size.width, lattice.view.size.height);
  }
  return kept + drawing;
}

std::vector<FrameRequest> latticeRequests(const std::vector<const BrickedVolume*>& volumes,
                                          const FrameRequest& request) {
  LatticeView lattice =
      ambientLattice(volumes.front()->manifest().geometry(), shownExtentOf(volumes, clippingsOf(request)));
  FrameRequest along = opacityRequest(request, lattice.view);
  if (along.volumes.empty()) along.volumes = {{along.transfer_function, along.shading, along.clipping}};
  along.sample_distance = kMostSampleDistance;
  std::vector<FrameRequest> out = {along};
  // A ray misses surfaces that the ray runs along. Along some of three axes a surface is met.
  for (int turns = 1; turns <= 2 && hasSurfaces(request); ++turns) {
    lattice = turned(lattice);
    along.view = lattice.view;
    out.push_back(along);
  }
  return out;
}

std::vector<FrameRequest> lightRequests(const std::vector<const BrickedVolume*>& volumes, const FrameRequest& request) {
  const ShownExtent extent = shownExtentOf(volumes, clippingsOf(request));
  if (!isIlluminated(request) || extent.corners.empty()) return {};
  std::vector<FrameRequest> out;
  if (request.shading.occlusion.strength > 0) out = latticeRequests(volumes, request);
  for (const Light& light : request.shading.lights) {
    if (!castsShadows(request.shading, light)) continue;
    const int edge_px = shadowEdgeOf(light, extent, request.view.size);
    for (const std::vector<ShadowView>& point : shadowMapViews(light, request.view, extent, edge_px)) {
      for (const ShadowView& map : point) out.push_back(opacityRequest(request, map.view));
    }
  }
  return out;
}

}  // namespace kiln
