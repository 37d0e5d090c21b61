#include "frame/pass/frame_drawing.h"

#include <algorithm>

#include "base/thread/profile_scope.h"
#include "frame/pass/aov_planes.h"
#include "frame/pass/make_pass.h"
#include "frame/pass/make_visibility.h"

namespace kiln {
namespace {

std::unique_ptr<FramePass> plannedPass(const BrickCache& cache, const FrameRequest& request) {
  const ProfileScope span(Activity::kPlan);
  return makePass(cache.stores(), request);
}

Image emptyImage(const PixelRect& pixels, const Aovs& aovs) {
  const ProfileScope span(Activity::kPlan);
  Image out(pixels.width(), pixels.height());
  addAovPlanes(aovs, out);
  return out;
}

}  // namespace

FrameDrawing::FrameDrawing(BrickCache& cache, const FrameRequest& request, Progress& progress)
    : cache_(cache),
      request_(request),
      progress_(progress),
      pass_(plannedPass(cache, request)),
      before_(cache.counts()) {
  std::size_t levels = 0;
  for (const BrickedVolume* const store : cache.stores()) levels = std::max(levels, store->manifest().levels.size());
  costs_.statistics.levels.assign(levels, {});
}

std::unique_ptr<Visibility> FrameDrawing::visibilityOf(const PixelRect& pixels) const {
  VisibilityOptions options = request_.visibility;
  if (!request_.engine().capabilities().composites) options.method = VisibilityMethod::kNone;
  const bool quincunx = request_.sampling().quincunx;
  // In the quincunx pattern two neighbouring pixels share a ray.
  PixelRect known = pixels;
  if (quincunx) known.x1 += known.x1 % 2;
  std::unique_ptr<Visibility> out = makeVisibilityOf(known, options, request_.tile_px);
  if (!quincunx) return out;
  // If `pixels` separates two such pixels and the ray belongs to the pixel outside, the pixel inside is closed: it is
  // never drawn.
  const auto close = [&](int x) {
    for (int y = pixels.y0 + (x + pixels.y0 + 1) % 2; y < pixels.y1; y += 2) out->close(x, y);
  };
  if (pixels.x0 % 2 != 0) close(pixels.x0);
  if (pixels.x1 % 2 != 0) close(pixels.x1 - 1);
  return out;
}

Image FrameDrawing::draw(const PixelRect& pixels) {
  progress_.throwIfCancelled("rendering");
  const std::unique_ptr<Visibility> visibility = visibilityOf(pixels);
  Image image = emptyImage(pixels, request_.aovs);
  const ProfileScope span(Activity::kWalk);
  TilePixels all{pixels, image.pixel(0, 0), std::ptrdiff_t{4} * image.width, aovPixels(request_.aovs, image, 0, 0)};
  if (request_.deep) image.deep = std::make_shared<DeepSamples>(pixels, *request_.deep, request_.view.origin_depth);
  all.deep = image.deep.get();
  all.shadows = request_.shadows;
  all.extinction = request_.extinction;
  // A threshold above zero in floats, too: a pixel without opacity is not closed.
  const float threshold = std::max(static_cast<float>(request_.opacity_threshold), 1e-30f);
  PassContext context{cache_, progress_, costs_};
  shown_ = pass_->draw({all, *visibility, threshold}, context);
  return image;
}

FrameStatistics FrameDrawing::finish() {
  cache_.settle();
  const CacheCounts after = cache_.counts();
  const BrickWalkCounts& walked = costs_.walked;
  FrameStatistics out = costs_.statistics;
  out.voxels_visited = costs_.drawn.visited;
  out.voxels_splats = costs_.drawn.splats;
  out.nodes_tested = costs_.drawn.nodes_tested + walked.nodes_tested;
  out.nodes_hidden = costs_.drawn.nodes_hidden + walked.nodes_hidden;
  out.bricks_total = walked.bricks;
  out.bricks_interesting = walked.interesting;
  out.bricks_hidden = walked.hidden;
  out.bricks_read = after.reads - before_.reads;
  out.bricks_unused = after.unused - before_.unused;
  out.bricks_damaged = out.damaged.size();
  out.bricks_read_bytes = after.read_bytes - before_.read_bytes;
  out.bricks_masked = walked.masked;
  out.bricks_emptied = after.emptied - before_.emptied;
  out.companion_reads = after.companion_reads - before_.companion_reads;
  out.companion_bytes = after.companion_bytes - before_.companion_bytes;
  out.bricks_shared = after.shared - before_.shared;
  out.bricks_shared_bytes = after.shared_bytes - before_.shared_bytes;
  out.slab_bytes = pass_->scratchBytes();
  out.load_s = after.load_seconds - before_.load_seconds;
  return out;
}

}  // namespace kiln
