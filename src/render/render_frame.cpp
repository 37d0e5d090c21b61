#include "render/render_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>

#include "base/elapsed.h"
#include "base/parallel.h"
#include "base/span.h"
#include "render/aov_planes.h"
#include "render/background.h"
#include "render/frame_drawing.h"
#include "render/panorama.h"

namespace kiln {
namespace {

void requireLevel(const StoreReader& store, const std::optional<int>& level) {
  const int levels = store.index().levels();
  if (!level || (*level >= 0 && *level < levels)) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("--level: there is no level {}; {} has {}, from 0 to {}", *level, store.path().string(),
                          levels == 1 ? "1 level" : fmt::format("{} levels", levels), levels - 1));
}

void requireRequest(const std::vector<const StoreReader*>& stores, const FrameRequest& request) {
  for (const StoreReader* const store : stores) {
    requireLevel(*store, request.level);
    requireLattice(request.lattice, store->manifest().volume_class, store->path());
  }
  if (request.lattice == Lattice::kRay && (!request.volumes.empty() || request.clipping.part || request.deep))
    throw Error(ErrorCode::kUsage, "--lattice ray: several volumes, parts and deep images have the pixel lattice");
  requireInterpolation(request.lattice, request.interpolation);
  requireMode(request.mode, request.lattice, request.interpolation, request.aovs);
  requireSampleDistance(request.lattice, request.mode, request.sample_distance);
  const int tile_px = request.tile_px;
  if (tile_px != 0 && (tile_px < kVisibilityTile || !std::has_single_bit(static_cast<unsigned>(tile_px)))) {
    throw Error(ErrorCode::kUsage, fmt::format("a tile of {} pixels: expected a power of two from {} on, or 0 for the "
                                               "whole frame",
                                               tile_px, kVisibilityTile));
  }
}

// But for what writes another frame's files meanwhile.
BusyTimes busySince(const BusyTimes& before) {
  BusyTimes out = BusyTimes::now().since(before);
  out.seconds[static_cast<std::size_t>(Activity::kWrite)] = 0;
  return out;
}

// The frame whose pixels are the sub-pixels of the request's.
FrameRequest ofSubPixels(FrameRequest request, int edge) {
  request.view = enlarged(request.view, edge);
  return request;
}

PixelRect subPixelsOf(const PixelRect& pixels, int edge) {
  return {edge * pixels.x0, edge * pixels.y0, edge * pixels.x1, edge * pixels.y1};
}

// Writes the means of edge × edge sub-pixels into the image's rows from `row` on.
void putMeans(const Image& sub_pixels, int edge, Image& image, int row) {
  const Span span(Activity::kFinish);
  const float share = 1.0f / static_cast<float>(edge * edge);
  parallelFor(static_cast<std::size_t>(sub_pixels.height / edge), [&](std::size_t i) {
    const int first = static_cast<int>(i);
    for (int x = 0; x < image.width; ++x) {
      float sum[4] = {};
      for (int y = edge * first; y < edge * (first + 1); ++y) {
        const float* const from = sub_pixels.pixel(edge * x, y);
        for (int k = 0; k < 4 * edge; ++k) sum[k & 3] += from[k];
      }
      float* const pixel = image.pixel(x, row + first);
      for (int channel = 0; channel < 4; ++channel) pixel[channel] = share * sum[channel];
    }
  });
}

// Bands of rows of sub-pixels end at borders of tiles, which are borders of pixels, too; pixels of one sample are one.
std::vector<PixelRect> bandsOf(const PixelRect& sub_pixels, const FrameRequest& request) {
  if (request.samples == 1) return {sub_pixels};
  constexpr int kTile = kVisibilityTile;
  const int step = std::max(request.band_px / kTile, 1) * kTile;
  std::vector<PixelRect> out;
  PixelRect band = sub_pixels;
  for (; band.y0 < sub_pixels.y1; band.y0 = band.y1) {
    band.y1 = std::min(sub_pixels.y1, band.y0 / kTile * kTile + step);
    out.push_back(band);
  }
  return out;
}

Image drawMeans(FrameDrawing& drawing, const PixelRect& pixels, int edge, const FrameRequest& request) {
  Image image(pixels.width(), pixels.height());
  addAovPlanes(request.aovs, image);
  for (const PixelRect& band : bandsOf(subPixelsOf(pixels, edge), request)) {
    Image sub_pixels = drawing.draw(band);
    const int row = band.y0 / edge - pixels.y0;
    putMeans(sub_pixels, edge, image, row);
    putAovs(request.aovs, request.view, sub_pixels, edge, image, row);
  }
  return image;
}

Image drawPixels(FrameDrawing& drawing, const PixelRect& pixels, const FrameRequest& request) {
  Image image = drawing.draw(pixels);
  const Span span(Activity::kFinish);
  putAovs(request.aovs, request.view, image, 1, image, 0);
  return image;
}

// What is projected onto a plane, and its pixels.
struct DrawnPlane {
  FrameRequest request;
  PixelRect pixels;
};

// Of a frame, in sub-pixels: itself; of a panorama, the faces that it is made of.
std::vector<DrawnPlane> planesOf(const FrameRequest& request) {
  const PixelRect pixels = drawnPixels(request.view.size, request.crop);
  const int edge = subPixelsAlongEdge(request.samples);
  if (request.view.projection != Projection::kEquirectangular)
    return {{ofSubPixels(request, edge), subPixelsOf(pixels, edge)}};
  const std::array<View, kPanoramaFaces> faces = panoramaFaces(request.view);
  const std::array<PixelRect, kPanoramaFaces> drawn = facePixels(request.view, pixels);
  std::vector<DrawnPlane> out;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (drawn[i].empty()) continue;
    out.push_back({request, drawn[i]});
    out.back().request.view = faces[i];
  }
  return out;
}

}  // namespace

std::vector<StoredBrick> bricksInView(const std::vector<const StoreReader*>& stores, const FrameRequest& request,
                                      BrickWalkCounts& counts) {
  requireRequest(stores, request);
  std::vector<StoredBrick> out;
  for (const DrawnPlane& plane : planesOf(request)) {
    const FramePlan plan(stores, plane.request);
    if (plan.mix) {
      counts = plan.mix->counts();
      const std::vector<StoredBrick> seen = plan.mix->inView(plane.pixels);
      out.insert(out.end(), seen.begin(), seen.end());
    } else {
      for (const BrickInView& brick : plan.bricks->inView(plane.pixels, counts)) out.push_back({brick.key});
    }
  }
  return out;
}

std::uint64_t stepsOfParts(const std::vector<const StoreReader*>& stores, const std::vector<FrameRequest>& eyes) {
  std::vector<DrawnPlane> planes;
  for (const FrameRequest& eye : eyes) {
    requireRequest(stores, eye);
    for (DrawnPlane& plane : planesOf(eye)) planes.push_back(std::move(plane));
  }
  std::uint64_t out = 0;
  for (const DrawnPlane& plane : planes) {
    const std::vector<PixelRect> bands = bandsOf(plane.pixels, plane.request);
    if (planes.size() == 1 && bands.size() == 1) return 0;
    const FramePlan plan(stores, plane.request);
    for (const PixelRect& band : bands) out += plan.stepsOf(band, plane.request.tile_px);
  }
  return out;
}

std::vector<BrickInView> bricksOnImage(const StoreReader& store, const FrameRequest& request) {
  requireRequest({&store}, request);
  const int edge = subPixelsAlongEdge(request.samples);
  const FrameRequest of_sub_pixels = ofSubPixels(request, edge);
  BrickWalkCounts ignored;
  return FramePlan({&store}, of_sub_pixels)
      .bricks->inView(subPixelsOf(drawnPixels(request.view.size, request.crop), edge), ignored);
}

std::uint64_t leastMixBytes(const std::vector<const StoreReader*>& stores, const FrameRequest& request) {
  requireRequest(stores, request);
  std::uint64_t out = 0;
  for (const DrawnPlane& plane : planesOf(request)) {
    const FramePlan plan(stores, plane.request);
    out = std::max(out, plan.mix->mostBytes(tilesOf(request.tile_px, plane.pixels, plane.pixels)));
  }
  return out;
}

FramePainter::FramePainter(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress)
    : request_(request), of_sub_pixels_(ofSubPixels(request, subPixelsAlongEdge(request.samples))) {
  const auto begin = std::chrono::steady_clock::now();
  const BusyTimes before = BusyTimes::now();
  requireRequest(cache.stores(), request);
  drawnPixels(request.view.size, request.crop);
  drawing_ = std::make_unique<FrameDrawing>(store, cache, of_sub_pixels_, progress);
  count(begin, before);
}

void FramePainter::count(std::chrono::steady_clock::time_point begin, const BusyTimes& before) {
  cost_.wall_s += secondsSince(begin);
  cost_.busy.add(busySince(before));
}

FramePainter::~FramePainter() = default;

Image FramePainter::draw(const PixelRect& pixels) {
  const auto begin = std::chrono::steady_clock::now();
  const BusyTimes before = BusyTimes::now();
  const int edge = subPixelsAlongEdge(request_.samples);
  Image image = edge == 1 ? drawPixels(*drawing_, pixels, request_) : drawMeans(*drawing_, pixels, edge, request_);
  {
    const Span span(Activity::kFinish);
    layOverBackground(image, pixels.y0, request_.view.size.height, request_.background);
  }
  count(begin, before);
  return image;
}

FrameStatistics FramePainter::finish() {
  const auto begin = std::chrono::steady_clock::now();
  const BusyTimes before = BusyTimes::now();
  FrameStatistics out = drawing_->finish();
  count(begin, before);
  out.wall_s = cost_.wall_s;
  out.busy = cost_.busy;
  out.threads = ThreadLimit::active();
  out.samples = static_cast<unsigned>(request_.samples);
  return out;
}

Image renderFrame(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress,
                  FrameStatistics& statistics) {
  if (request.view.projection == Projection::kEquirectangular) {
    const auto begin = std::chrono::steady_clock::now();
    const BusyTimes before = BusyTimes::now();
    requireRequest(cache.stores(), request);
    Image panorama = renderPanorama(store, cache, request, progress, statistics);
    statistics.wall_s = secondsSince(begin);
    statistics.busy = busySince(before);
    return panorama;
  }
  FramePainter painter(store, cache, request, progress);
  Image image = painter.draw(drawnPixels(request.view.size, request.crop));
  statistics = painter.finish();
  return image;
}

}  // namespace kiln
