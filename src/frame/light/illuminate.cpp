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

  // Without maps if the light casts no shadows.
  ShadowedLight shadow(std::size_t i, int edge_px) const {
    const Light& light = request.shading.lights[i];
    ShadowedLight out;
    if (!castsShadows(request.shading, light)) return out;
    out.light = light;
    out.place = standing(light, request.view).place;
    out.edge_px = edge_px;
    const std::vector<std::vector<ShadowView>> points = shadowMapViews(light, request, extent);
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
    if (const ShadowedLight* const known = knownShadow(request, i, earlier)) out->lights[i] = *known;
  }
  if (request.shading.occlusion.strength > 0) {
    out->ambient = earlier->ambient;
    out->ambient_radius = earlier->ambient_radius;
  }
  return out;
}

void illuminate(BrickCache& cache, Progress& progress, FrameRequest& request, FrameStatistics& statistics) {
  if (request.illumination || !isIlluminated(request)) return;
  const AmbientOcclusion& occlusion = request.shading.occlusion;
  auto out = std::make_shared<Illumination>();
  out->scene = shadowSceneOf(request);
  const Illumination* previous = request.last_illumination != nullptr ? request.last_illumination->get() : nullptr;
  if (previous != nullptr && !(previous->scene == out->scene)) {
    previous = nullptr;
    request.last_illumination->reset();
  }
  const LightDrawing drawing{cache, request, shownExtentOf(cache.stores(), out->scene.clippings), progress, statistics};
  if (drawing.extent.corners.empty()) return;
  if (occlusion.strength > 0) {
    out->ambient_radius = ambientRadius(occlusion, drawing.extent);
    const bool known = previous != nullptr && previous->ambient && previous->ambient_radius == out->ambient_radius;
    out->ambient = known ? previous->ambient : drawing.ambient(out->ambient_radius);
  }
  // A cancelled frame leaves the occlusion to the next frame: often only lights differ.
  if (previous == nullptr && request.last_illumination != nullptr)
    *request.last_illumination = std::make_shared<Illumination>(*out);
  for (std::size_t i = 0; i < request.shading.lights.size(); ++i) {
    const ShadowedLight* const known = knownShadow(request, i, previous);
    const int edge_px = shadowEdgeOf(request.shading.lights[i], drawing.extent, request.view.size);
    out->lights.push_back(known != nullptr && known->edge_px == edge_px ? *known : drawing.shadow(i, edge_px));
  }
  request.illumination = std::move(out);
  if (request.last_illumination != nullptr) *request.last_illumination = request.illumination;
}

}  // namespace kiln
