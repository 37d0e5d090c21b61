#include "frame/light/illuminate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engine/capabilities.h"
#include "frame/light/gather_ambient.h"
#include "frame/light/shadow_views.h"
#include "frame/pass/frame_drawing.h"
#include "frame/pass/frame_progress.h"
#include "frame/pass/make_visibility.h"
#include "grid/point_bounds.h"
#include "scene/camera/framing.h"

namespace kiln {
namespace {

// Smallest edge of a shadow map by default: a small picture of a large object has fine shadows, too. unit: pixels.
constexpr int kLeastMapEdge = 512;
// Pixels of a shadow map along a voxel's edge, at most. With one, borders of shadows on smooth surfaces are combs.
constexpr int kMapPixelsOfVoxel = 2;
// Height over a surface of the layers that shadow it. Smaller heights darken surfaces by their own layers: a surface's
// opacity rises over some two voxels. unit: voxels or pixels of the map, the longer.
constexpr double kShadowStart = 1.5;
// Rays along the longest edge of the lattice for ambient occlusion.
constexpr int kLatticeEdge = 256 * kRaysOfCell;
// Default radius of ambient occlusion. unit: longest edges of the volumes.
constexpr double kOcclusionRadius = 0.1;
// Rows of a light's view drawn at a time, which bounds the memory of the pixels. unit: pixels.
constexpr int kOpacityBand = 256;

std::vector<Clipping> clippingsOf(const FrameRequest& request) {
  std::vector<Clipping> out;
  for (const VolumeRequest& volume : request.volumes) out.push_back(volume.clipping);
  if (out.empty()) out.push_back(request.clipping);
  for (Clipping& clipping : out) clipping.part.reset();
  return out;
}

ShadowScene sceneOf(const FrameRequest& request) {
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

// The extent of all volumes after their regions.
struct ShownExtent {
  std::vector<glm::dvec3> corners;
  double voxel = 0;          // smallest mean edge of a voxel. unit: world
  std::int64_t longest = 0;  // edge of a volume. unit: voxels
};

ShownExtent extentOf(const std::vector<const BrickedVolume*>& volumes, const std::vector<Clipping>& clippings) {
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

int edgeOf(const Light& light, const ShownExtent& extent, const ImageSize& picture) {
  if (light.shadow.resolution > 0) return std::max(light.shadow.resolution, kLeastShadowEdge);
  const int side = std::clamp(std::max(picture.width, picture.height), kLeastMapEdge, kShadowEdge);
  const auto edge = static_cast<int>(std::min<std::int64_t>(side, kMapPixelsOfVoxel * extent.longest));
  // A penumbra needs fewer pixels, and each of its lights a map.
  return std::max(light.shadow.softness > 0 ? edge / 2 : edge, kLeastShadowEdge);
}

// Returns the request whose drawing has the opacities of a view only.
FrameRequest ofOpacities(FrameRequest request, const View& view) {
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

// requires: ofOpacities, with a place for them.
void drawOpacities(BrickCache& cache, const FrameRequest& request, ViewsProgress& progress,
                   FrameStatistics& statistics) {
  FrameDrawing drawing(cache, request, progress);
  const ImageSize& size = request.view.size;
  for (int y = 0; y < size.height; y += kOpacityBand) {
    const int end = std::min(y + kOpacityBand, size.height);
    progress.begin(end - y);
    drawing.draw({0, y, size.width, end});
    progress.end();
  }
  statistics.addView(drawing.finish());
}

// Returns the rows of pixels of all views.
template <class Seen>
std::uint64_t rowsOf(const std::vector<Seen>& views) {
  std::uint64_t out = 0;
  for (const Seen& seen : views) out += static_cast<std::uint64_t>(seen.view.size.height);
  return out;
}

// Returns the view along the z axis of the first volume.
LatticeView latticeOf(const VolumeGeometry& first, const ShownExtent& extent) {
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

bool isIlluminated(const FrameRequest& request) {
  return hasLight(request) && request.engine().capabilities().composites && isShaded(request.shading);
}

// Returns the views of the shadow maps of a light, for each of its points; none if the light casts no shadows.
std::vector<std::vector<ShadowView>> mapsOf(const Light& light, const FrameRequest& request,
                                            const ShownExtent& extent) {
  std::vector<std::vector<ShadowView>> out;
  if (!castsShadows(request.shading, light)) return out;
  glm::dvec3 centre(0);
  for (const glm::dvec3& corner : extent.corners) centre += corner / static_cast<double>(extent.corners.size());
  for (const Light& point : pointsOf(light, request.view, centre))
    out.push_back(shadowViews(point, extent.corners, edgeOf(light, extent, request.view.size)));
  return out;
}

// Nothing is farther than the diagonal of all volumes.
double radiusOf(const AmbientOcclusion& occlusion, const ShownExtent& extent) {
  if (occlusion.radius > 0) {
    PointBounds world;
    for (const glm::dvec3& corner : extent.corners) world.add(corner);
    return std::min(occlusion.radius, glm::distance(world.lo, world.hi));
  }
  return kOcclusionRadius * static_cast<double>(extent.longest) * extent.voxel;
}

}  // namespace

std::uint64_t illuminationBytes(const std::vector<const BrickedVolume*>& volumes,
                                const std::vector<Clipping>& clippings, const Shading& shading,
                                const ImageSize& picture) {
  const ShownExtent extent = extentOf(volumes, clippings);
  if (extent.corners.empty() || !shading.phong) return 0;
  const auto bandBytes = [](int width, int height) {
    const int rows = std::min(height, kOpacityBand);
    return 4 * sizeof(float) * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(rows) +
           visibilityBytes(VisibilityMethod::kMask, {width, rows});
  };
  std::uint64_t kept = 0, drawing = 0;
  for (const Light& light : shading.lights) {
    if (!castsShadows(shading, light)) continue;
    const int edge = edgeOf(light, extent, picture);
    // The views of a far light have equal bounds for all directions.
    std::size_t maps = isFar(light.kind) ? 1 : shadowViews(light, extent.corners, edge).size();
    if (light.shadow.softness > 0) maps = isFar(light.kind) ? kSoftLights : 6 * kSoftLights;
    const std::uint64_t finished = DeepShadowMap::bytesFor(edge, edge, false);
    kept += maps * finished;
    drawing = std::max(drawing, DeepShadowMap::bytesFor(edge, edge, true) - finished + bandBytes(edge, edge));
  }
  if (shading.occlusion.strength > 0) {
    const LatticeView lattice = latticeOf(volumes.front()->manifest().geometry(), extent);
    kept += ambientBytes(lattice) + bandBytes(lattice.view.size.width, lattice.view.size.height);
  }
  return kept + drawing;
}

std::vector<FrameRequest> latticeRequests(const std::vector<const BrickedVolume*>& volumes,
                                          const FrameRequest& request) {
  LatticeView lattice = latticeOf(volumes.front()->manifest().geometry(), extentOf(volumes, clippingsOf(request)));
  FrameRequest along = ofOpacities(request, lattice.view);
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

namespace {

// Returns the maps of light i in an earlier frame of the same scene; null if the light differs or casts no shadows.
const ShadowedLight* knownShadow(const FrameRequest& request, std::size_t i, const Illumination* earlier) {
  const Light& light = request.shading.lights[i];
  if (earlier == nullptr || i >= earlier->lights.size() || !castsShadows(request.shading, light)) return nullptr;
  const ShadowedLight& known = earlier->lights[i];
  return known.light == light && known.place == standing(light, request.view).place ? &known : nullptr;
}

// Draws the views of lights of a frame.
struct LightDrawing {
  BrickCache& cache;
  const FrameRequest& request;
  const ShownExtent extent;
  Progress& progress;
  FrameStatistics& statistics;

  std::shared_ptr<const AmbientGrid> ambient(double radius) const {
    ExtinctionLattice lattice(latticeOf(cache.stores().front()->manifest().geometry(), extent));
    std::vector<FrameRequest> views = latticeRequests(cache.stores(), request);
    ViewsProgress of_views("ambient occlusion", rowsOf(views), progress);
    for (FrameRequest& along : views) {
      along.extinction = &lattice;
      drawOpacities(cache, along, of_views, statistics);
      lattice.turn();
    }
    return std::make_shared<AmbientGrid>(gatherAmbient(lattice, radius, progress));
  }

  // Without maps if the light casts no shadows.
  ShadowedLight shadow(std::size_t i, int edge_px) const {
    const Light& light = request.shading.lights[i];
    ShadowedLight out;
    if (!castsShadows(request.shading, light)) return out;
    out.light = light;
    out.place = standing(light, request.view).place;
    out.edge_px = edge_px;
    const std::vector<std::vector<ShadowView>> points = mapsOf(light, request, extent);
    std::uint64_t rows = 0;
    for (const std::vector<ShadowView>& point : points) rows += rowsOf(point);
    const std::string step = fmt::format("shadows of light {}", i + 1);
    ViewsProgress of_maps(step.c_str(), rows, progress);
    for (const std::vector<ShadowView>& point : points) {
      std::vector<std::shared_ptr<const DeepShadowMap>> maps;
      for (const ShadowView& view : point) {
        auto map = std::make_shared<DeepShadowMap>(view.view, view.depths);
        FrameRequest of_light = ofOpacities(request, view.view);
        of_light.shadows = map.get();
        drawOpacities(cache, of_light, of_maps, statistics);
        map->finish();
        out.start = std::max(out.start, kShadowStart * std::max(extent.voxel, pixelEdge(view)));
        maps.push_back(std::move(map));
      }
      out.points.push_back(std::move(maps));
    }
    return out;
  }
};

}  // namespace

std::shared_ptr<const Illumination> knownIllumination(const FrameRequest& request, const Illumination* earlier) {
  auto out = std::make_shared<Illumination>();
  out->scene = sceneOf(request);
  out->lights.resize(request.shading.lights.size());
  if (earlier == nullptr || earlier->scene.functions != out->scene.functions ||
      earlier->scene.clippings != out->scene.clippings)
    return out;
  for (std::size_t i = 0; i < out->lights.size(); ++i) {
    if (const ShadowedLight* const known = knownShadow(request, i, earlier)) out->lights[i] = *known;
  }
  if (request.shading.occlusion.strength > 0) {
    out->ambient = earlier->ambient;
    out->ambient_radius = earlier->ambient_radius;
  }
  return out;
}

std::vector<FrameRequest> lightRequests(const std::vector<const BrickedVolume*>& volumes, const FrameRequest& request) {
  const ShownExtent extent = extentOf(volumes, clippingsOf(request));
  if (!isIlluminated(request) || extent.corners.empty()) return {};
  std::vector<FrameRequest> out;
  if (request.shading.occlusion.strength > 0) out = latticeRequests(volumes, request);
  for (const Light& light : request.shading.lights) {
    for (const std::vector<ShadowView>& point : mapsOf(light, request, extent)) {
      for (const ShadowView& map : point) out.push_back(ofOpacities(request, map.view));
    }
  }
  return out;
}

void illuminate(BrickCache& cache, Progress& progress, FrameRequest& request, FrameStatistics& statistics) {
  if (request.illumination || !isIlluminated(request)) return;
  const AmbientOcclusion& occlusion = request.shading.occlusion;
  auto out = std::make_shared<Illumination>();
  out->scene = sceneOf(request);
  const Illumination* previous = request.last_illumination != nullptr ? request.last_illumination->get() : nullptr;
  if (previous != nullptr && !(previous->scene == out->scene)) {
    previous = nullptr;
    request.last_illumination->reset();
  }
  const LightDrawing drawing{cache, request, extentOf(cache.stores(), out->scene.clippings), progress, statistics};
  if (drawing.extent.corners.empty()) return;
  if (occlusion.strength > 0) {
    out->ambient_radius = radiusOf(occlusion, drawing.extent);
    const bool known = previous != nullptr && previous->ambient && previous->ambient_radius == out->ambient_radius;
    out->ambient = known ? previous->ambient : drawing.ambient(out->ambient_radius);
  }
  // A cancelled frame leaves the occlusion to the next frame: often only lights differ.
  if (previous == nullptr && request.last_illumination != nullptr)
    *request.last_illumination = std::make_shared<Illumination>(*out);
  for (std::size_t i = 0; i < request.shading.lights.size(); ++i) {
    const ShadowedLight* const known = knownShadow(request, i, previous);
    const int edge_px = edgeOf(request.shading.lights[i], drawing.extent, request.view.size);
    out->lights.push_back(known != nullptr && known->edge_px == edge_px ? *known : drawing.shadow(i, edge_px));
  }
  request.illumination = std::move(out);
  if (request.last_illumination != nullptr) *request.last_illumination = request.illumination;
}

}  // namespace kiln
