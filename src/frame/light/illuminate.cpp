#include "frame/light/illuminate.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "frame/light/gather_ambient.h"
#include "frame/light/light_plan.h"
#include "frame/light/shadow_views.h"
#include "frame/pass/frame_drawing.h"
#include "frame/pass/frame_progress.h"

namespace kiln {
namespace {

// Height over a surface of the layers that shadow it. Smaller heights darken surfaces by their own layers: a surface's
// opacity rises over some two voxels. unit: voxels or pixels of the map, the longer.
constexpr double kShadowStart = 1.5;

// requires: `request` is of opacities and has a map or a lattice to fill.
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

// Returns the maps of light i in an earlier frame of the same scene; null if the light differs or casts no shadows.
const ShadowedLight* knownShadow(const FrameRequest& request, std::size_t i, const Illumination& earlier) {
  const Light& light = request.shading.lights[i];
  if (i >= earlier.lights.size() || !castsShadows(request.shading, light)) return nullptr;
  const ShadowedLight& known = earlier.lights[i];
  return known.light == light && known.place == standing(light, request.view).place ? &known : nullptr;
}

// Returns the parts of an earlier illumination, which may be null, that a frame of the scene would draw again.
std::shared_ptr<Illumination> keptIllumination(const FrameRequest& request, ShadowScene scene,
                                               const ShownExtent& extent, const Illumination* earlier) {
  const std::vector<Light>& lights = request.shading.lights;
  const AmbientOcclusion& occlusion = request.shading.occlusion;
  auto out = std::make_shared<Illumination>();
  out->scene = std::move(scene);
  out->lights.resize(lights.size());
  if (occlusion.strength > 0) out->ambient_radius = ambientRadius(occlusion, extent);
  if (earlier == nullptr || !(earlier->scene == out->scene)) return out;
  if (earlier->ambient_radius == out->ambient_radius) out->ambient = earlier->ambient;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const ShadowedLight* const known = knownShadow(request, i, *earlier);
    if (known != nullptr && known->edge_px == shadowEdgeOf(lights[i], extent, request.view.size))
      out->lights[i] = *known;
  }
  return out;
}

// Draws the views of lights of a frame.
struct LightDrawing {
  BrickCache& cache;
  const FrameRequest& request;
  const ShownExtent extent;
  Progress& progress;
  FrameStatistics& statistics;

  std::shared_ptr<const AmbientGrid> ambient(double radius) const {
    ExtinctionLattice lattice(ambientLattice(cache.stores().front()->manifest().geometry(), extent));
    std::vector<FrameRequest> views = latticeRequests(cache.stores(), request);
    ViewsProgress of_views("ambient occlusion", rowsOf(views), progress);
    for (FrameRequest& along : views) {
      along.extinction = &lattice;
      drawOpacities(cache, along, of_views, statistics);
      lattice.turn();
    }
    return std::make_shared<AmbientGrid>(gatherAmbient(lattice, radius, progress));
  }

  // requires: the light casts shadows.
  ShadowedLight shadow(std::size_t i) const {
    const Light& light = request.shading.lights[i];
    ShadowedLight out;
    out.light = light;
    out.place = standing(light, request.view).place;
    out.edge_px = shadowEdgeOf(light, extent, request.view.size);
    const std::vector<std::vector<ShadowView>> points = shadowMapViews(light, request.view, extent, out.edge_px);
    std::uint64_t rows = 0;
    for (const std::vector<ShadowView>& point : points) rows += rowsOf(point);
    const std::string step = fmt::format("shadows of light {}", i + 1);
    ViewsProgress of_maps(step.c_str(), rows, progress);
    for (const std::vector<ShadowView>& point : points) {
      std::vector<std::shared_ptr<const DeepShadowMap>> maps;
      for (const ShadowView& view : point) {
        auto map = std::make_shared<DeepShadowMap>(view.view, view.depths);
        FrameRequest of_light = opacityRequest(request, view.view);
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
  out->scene = shadowSceneOf(request);
  out->lights.resize(request.shading.lights.size());
  if (earlier == nullptr || earlier->scene.functions != out->scene.functions ||
      earlier->scene.clippings != out->scene.clippings)
    return out;
  for (std::size_t i = 0; i < out->lights.size(); ++i) {
    if (const ShadowedLight* const known = knownShadow(request, i, *earlier)) out->lights[i] = *known;
  }
  if (request.shading.occlusion.strength > 0) {
    out->ambient = earlier->ambient;
    out->ambient_radius = earlier->ambient_radius;
  }
  return out;
}

void illuminate(BrickCache& cache, Progress& progress, FrameRequest& request, FrameStatistics& statistics) {
  if (request.illumination || !isIlluminated(request)) return;
  std::shared_ptr<const Illumination>* const last = request.last_illumination;
  ShadowScene scene = shadowSceneOf(request);
  const LightDrawing drawing{cache, request, shownExtentOf(cache.stores(), scene.clippings), progress, statistics};
  if (drawing.extent.corners.empty()) return;
  const auto out = keptIllumination(request, std::move(scene), drawing.extent, last != nullptr ? last->get() : nullptr);
  // Frees the other parts before new parts take memory. A cancelled frame leaves its finished parts to the next frame.
  if (last != nullptr) *last = out;
  if (request.shading.occlusion.strength > 0 && !out->ambient) out->ambient = drawing.ambient(out->ambient_radius);
  for (std::size_t i = 0; i < out->lights.size(); ++i) {
    if (castsShadows(request.shading, request.shading.lights[i]) && out->lights[i].points.empty())
      out->lights[i] = drawing.shadow(i);
  }
  request.illumination = out;
}

}  // namespace kiln
