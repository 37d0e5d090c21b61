#include "frame/render_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "base/elapsed.h"
#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "frame/background.h"
#include "frame/empty_frame.h"
#include "frame/light/illuminate.h"
#include "frame/panorama.h"
#include "frame/part_image.h"
#include "frame/pass/aov_planes.h"
#include "frame/pass/frame_drawing.h"
#include "frame/pass/make_pass.h"
#include "frame/pixel_filter.h"
#include "grid/point_bounds.h"
#include "scene/camera/framing.h"

namespace kiln {
namespace {

void requireRequest(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request) {
  for (const BrickedVolume* const store : stores) {
    if (request.level) store->requireLevel(*request.level);
  }
  requireOptions(request.engine(),
                 {request.interpolation, request.samples, request.sample_distance, request.aovs, request.coarser});
  requireSurfaces(request.engine(), request.transfer_function);
  for (const VolumeRequest& volume : request.volumes) requireSurfaces(request.engine(), volume.transfer_function);
  const int tile_px = request.tile_px;
  static_assert(kLeastTile_px == kVisibilityTile);
  if (tile_px != 0 && (tile_px < kVisibilityTile || !std::has_single_bit(static_cast<unsigned>(tile_px)))) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--tile: expected a power of two from {} on, or 0 for the whole frame (found {})",
                            kVisibilityTile, tile_px));
  }
}

// Excludes writing, which may be another frame's.
BusyTimes busySince(const BusyTimes& before) {
  BusyTimes out = BusyTimes::now().since(before);
  out.seconds[static_cast<std::size_t>(Activity::kWrite)] = 0;
  return out;
}

PixelFilter filterOf(const FrameRequest& request) {
  return pixelFilterOf(request.engine(), request.samples, request.filters_rays && !request.deep);
}

// Several volumes: the origin of view space is near the box around all volumes, independent of their order.
View drawnViewOf(const View& view, const std::vector<const BrickedVolume*>& stores) {
  if (stores.size() == 1) return drawnView(view, stores.front()->manifest().geometry());
  PointBounds world;
  for (const BrickedVolume* const store : stores) {
    for (const glm::dvec3& corner : store->manifest().geometry().corners()) world.add(corner);
  }
  const glm::dvec3 centre = 0.5 * (world.lo + world.hi);
  return nearVolume(view, centre, glm::distance(world.hi, centre));
}

// The frame whose pixels are the sub-pixels of the request's.
FrameRequest ofSubPixels(FrameRequest request, int edge, const std::vector<const BrickedVolume*>& stores) {
  request.view = enlarged(drawnViewOf(request.view, stores), edge);
  return request;
}

Image drawFiltered(FrameDrawing& drawing, const PixelRect& pixels, const PixelFilter& filter,
                   const FrameRequest& request, const View& drawn_view) {
  Image image(pixels.width(), pixels.height());
  addAovPlanes(request.aovs, image);
  for (const PixelRect& band : bandsOf(pixels, request.view.size, filter, request.band_px)) {
    const PixelRect drawn = filter.samplesOf(band, request.view.size);
    Image samples = drawing.draw(drawn);
    const int row = band.y0 - pixels.y0, edge = filter.edge();
    filter.put(samples, drawing.shown(), band, image, row);
    const ProfileScope span(Activity::kFinish);
    const SubPixels from{samples, edge, edge * band.x0 - drawn.x0, edge * band.y0 - drawn.y0, band.height()};
    putAovs(request.aovs, drawn_view, from, image, row);
  }
  return image;
}

Image drawInPlace(FrameDrawing& drawing, const PixelRect& pixels, const PixelFilter& filter,
                  const FrameRequest& request, const View& drawn_view) {
  Image image = drawing.draw(pixels);
  const ProfileScope span(Activity::kFinish);
  putAovs(request.aovs, drawn_view, {image, 1, 0, 0, image.height}, image, 0);
  if (filter.none()) return image;
  const PixelRect& shown = drawing.shown();
  filter.apply(image, {shown.x0 - pixels.x0, shown.y0 - pixels.y0, shown.x1 - pixels.x0, shown.y1 - pixels.y0});
  return image;
}

// The sub-pixels projected onto a plane, and the part drawn at a time.
struct DrawnPlane {
  FrameRequest request;
  PixelRect pixels;
  std::vector<PixelRect> bands;
};

// Returns request, pixels and bands of a frame whose image is one plane.
DrawnPlane planeOf(const FrameRequest& request, const std::vector<const BrickedVolume*>& stores,
                   const PixelRect& pixels) {
  const PixelFilter filter = filterOf(request);
  const ImageSize& size = request.view.size;
  DrawnPlane out{ofSubPixels(request, filter.edge(), stores), filter.samplesOf(pixels, size),
                 request.clipping.part ? std::vector{pixels} : bandsOf(pixels, size, filter, request.band_px)};
  for (PixelRect& band : out.bands) band = filter.samplesOf(band, size);
  return out;
}

FrameRequest fromEye(FrameRequest request, const View& eye) {
  request.view = eye;
  request.eyes.clear();
  return request;
}

// Returns the views of a frame: its own, those of a lens, or the faces of a panorama.
std::vector<DrawnPlane> planesOf(const FrameRequest& request, const std::vector<const BrickedVolume*>& stores) {
  const PixelRect pixels = drawnPixels(request.view.size, request.crop);
  std::vector<DrawnPlane> out;
  for (const View& eye : request.eyes) out.push_back(planeOf(fromEye(request, eye), stores, pixels));
  if (!out.empty()) return out;
  if (request.view.projection != Projection::kEquirectangular) return {planeOf(request, stores, pixels)};
  const std::array<View, kPanoramaFaces> faces = panoramaFaces(request.view);
  const std::array<PixelRect, kPanoramaFaces> drawn = facePixels(request.view, pixels);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (!drawn[i].empty()) out.push_back(planeOf(faceOf(request, faces[i]), stores, drawn[i]));
  }
  return out;
}

}  // namespace

View drawnView(const View& view, const VolumeGeometry& volume) {
  const glm::dvec3 centre = centreOf(volume);
  return nearVolume(view, centre, glm::distance(volume.worldOf(glm::dvec3(-0.5)), centre));
}

std::vector<StoredBrick> bricksInView(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request,
                                      BrickWalkCounts& counts) {
  requireRequest(stores, request);
  std::vector<StoredBrick> out;
  for (const DrawnPlane& plane : planesOf(request, stores)) {
    for (const BrickOfFrame& brick : makePass(stores, plane.request)->inView(plane.pixels, counts))
      out.push_back(brick.brick);
  }
  return out;
}

std::uint64_t stepsOfParts(const std::vector<const BrickedVolume*>& stores, const std::vector<FrameRequest>& eyes) {
  std::vector<DrawnPlane> planes;
  for (const FrameRequest& eye : eyes) {
    requireRequest(stores, eye);
    for (DrawnPlane& plane : planesOf(eye, stores)) planes.push_back(std::move(plane));
  }
  std::uint64_t out = 0;
  for (const DrawnPlane& plane : planes) {
    const bool channels = plane.request.engine().kind() == EngineKind::kProjection && !plane.request.volumes.empty();
    if (planes.size() == 1 && plane.bands.size() == 1 && !channels) return 0;
    const std::unique_ptr<FramePass> pass = makePass(stores, plane.request);
    for (const PixelRect& band : plane.bands) out += pass->steps(band);
  }
  return out;
}

std::vector<BrickOfFrame> bricksOnImage(const BrickedVolume& store, const FrameRequest& request) {
  requireRequest({&store}, request);
  const DrawnPlane plane = planeOf(request, {&store}, drawnPixels(request.view.size, request.crop));
  BrickWalkCounts ignored;
  return makePass({&store}, plane.request)->inView(plane.pixels, ignored);
}

std::uint64_t bytesAtOnce(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request) {
  requireRequest(stores, request);
  std::uint64_t out = 0;
  for (const DrawnPlane& plane : planesOf(request, stores)) {
    out = std::max(out, makePass(stores, plane.request)->bytesAtOnce(plane.pixels));
  }
  return out;
}

FramePainter::FramePainter(BrickCache& cache, const FrameRequest& request, Progress& progress)
    : cache_(cache), progress_(progress), request_(request) {
  const auto begin = std::chrono::steady_clock::now();
  const BusyTimes before = BusyTimes::now();
  requireRequest(cache.stores(), request);
  drawnPixels(request.view.size, request.crop);
  illuminate(cache, progress, request_, lights_);
  if (request_.eyes.empty()) beginView(request_);
  count(begin, before);
}

void FramePainter::beginView(const FrameRequest& eye) {
  of_sub_pixels_ = ofSubPixels(eye, filterOf(eye).edge(), cache_.stores());
  drawing_ = std::make_unique<FrameDrawing>(cache_, of_sub_pixels_, progress_);
}

void FramePainter::endView() {
  drawn_.merge(drawing_->finish());
  drawing_.reset();
}

void FramePainter::count(std::chrono::steady_clock::time_point begin, const BusyTimes& before) {
  cost_.wall_s += secondsSince(begin);
  cost_.busy.add(busySince(before));
}

FramePainter::~FramePainter() = default;

Image FramePainter::drawView(const PixelRect& pixels) {
  const PixelFilter filter = filterOf(request_);
  const View& view = of_sub_pixels_.view;
  return filter.inPlace(pixels, request_.view.size) ? drawInPlace(*drawing_, pixels, filter, request_, view)
                                                    : drawFiltered(*drawing_, pixels, filter, request_, view);
}

// Draws one view after another, so that a lens needs the scratch memory of one.
Image FramePainter::drawThroughLens(const PixelRect& pixels) {
  Image mean;
  const auto weight = 1.0f / static_cast<float>(request_.eyes.size());
  for (const View& eye : request_.eyes) {
    beginView(fromEye(request_, eye));
    Image image = drawView(pixels);
    endView();
    const ProfileScope span(Activity::kFinish);
    for (float& value : image.rgba) value *= weight;
    if (mean.rgba.empty())
      mean = std::move(image);
    else
      std::transform(mean.rgba.begin(), mean.rgba.end(), image.rgba.begin(), mean.rgba.begin(), std::plus<>());
  }
  return mean;
}

Image FramePainter::draw(const PixelRect& pixels) {
  const auto begin = std::chrono::steady_clock::now();
  const BusyTimes before = BusyTimes::now();
  Image image;
  if (request_.clipping.part) {
    image = drawing_->draw(filterOf(request_).samplesOf(pixels, request_.view.size));
    premultiplyPlanes(request_.aovs, of_sub_pixels_.view, image);
  } else {
    image = request_.eyes.empty() ? drawView(pixels) : drawThroughLens(pixels);
    const ProfileScope span(Activity::kFinish);
    cost_.visible = cost_.visible || isVisible(image);
    layOverBackground(image, pixels.y0, request_.view.size.height, request_.background);
  }
  count(begin, before);
  return image;
}

FrameStatistics FramePainter::finish() {
  const auto begin = std::chrono::steady_clock::now();
  const BusyTimes before = BusyTimes::now();
  if (drawing_) endView();
  FrameStatistics out = drawn_;
  out.addLights(lights_);
  count(begin, before);
  out.visible = cost_.visible;
  out.wall_s = cost_.wall_s;
  out.busy = cost_.busy;
  out.threads = ThreadLimit::active();
  out.samples = static_cast<unsigned>(request_.samples);
  return out;
}

Image renderFrame(BrickCache& cache, const FrameRequest& request, Progress& progress, FrameStatistics& statistics) {
  if (request.view.projection == Projection::kEquirectangular) {
    const auto begin = std::chrono::steady_clock::now();
    const BusyTimes before = BusyTimes::now();
    requireRequest(cache.stores(), request);
    Image panorama = renderPanorama(cache, request, progress, statistics);
    statistics.wall_s = secondsSince(begin);
    statistics.busy = busySince(before);
    return panorama;
  }
  FramePainter painter(cache, request, progress);
  Image image = painter.draw(drawnPixels(request.view.size, request.crop));
  statistics = painter.finish();
  return image;
}

}  // namespace kiln
