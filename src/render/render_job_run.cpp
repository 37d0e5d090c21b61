#include "render/render_job_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "base/memory.h"
#include "base/parallel.h"
#include "output/image_file.h"
#include "render/frame_memory.h"

namespace kiln {
namespace {

double secondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void writePicture(RenderJob job, const RenderResult& result, const View& view) {
  const std::uint64_t damaged = result.statistics.frames.back().bricks_damaged;
  job.picture.skip_damaged = damaged > 0;  // a whole picture's header does not depend on it
  ImageMetadata metadata;
  if (damaged > 0) metadata.text["kiln:damagedBricks"] = std::to_string(damaged);
  if (const auto& crop = job.picture.crop)
    metadata.whole = {crop->x0, crop->y0, job.picture.size.width, job.picture.size.height};
  metadata.world_to_camera = exrWorldToCamera(view);
  metadata.world_to_ndc = exrWorldToNdc(view);
  metadata.text["kiln:job"] = resolvedJobText(job, result.camera, result.transfer_function);
  metadata.text["kiln:version"] = KILN_VERSION;
  writeImage(result.image, metadata, {job.output.exr_float, job.output.png_bits}, job.output.path);
}

}  // namespace

Camera cameraFor(const PictureOptions& picture, const StoreReader& store) {
  return picture.camera.resolve(store.manifest().geometry(), picture.size);
}

TransferFunction transferFunctionFor(const PictureOptions& picture, const StoreReader& store) {
  return resolve(picture.transfer_function, picture.window, store.manifest());
}

FrameRequest frameRequest(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function) {
  FrameRequest request;
  request.view = resolve(camera, job.picture.size);
  request.transfer_function = transfer_function;
  request.shading = job.picture.shading;
  request.clipping = job.picture.clipping;
  request.background = job.picture.background;
  request.opacity_threshold = job.picture.opacity_threshold;
  request.lattice = job.picture.lattice;
  request.interpolation = job.picture.interpolation;
  request.crop = job.picture.crop;
  request.samples = job.picture.samples;
  request.aovs = job.picture.aovs;
  request.level = job.picture.level;
  request.visibility = job.speed.visibility;
  request.tile_px = job.speed.tile_px;
  return request;
}

RenderResult runRenderJob(const RenderJob& job, int repeat, Progress& progress) {
  if (!job.output.path.empty()) requireImagePath(job.output.path, job.picture.aovs.any());
  const ThreadLimit threads(job.speed.threads);
  const StoreReader store(job.volume);
  const FrameMemory memory = frameMemory(store, job);
  // One thread reads nothing ahead, so that its statistics repeat.
  const unsigned readers = ThreadLimit::active() > 1 ? ThreadLimit::active() : 0;
  BrickCache::SkipHandler skip;
  if (job.picture.skip_damaged)
    skip = [&](const Error& damage) { progress.note(std::string("warning: drawn without ") + damage.what()); };
  BrickCache cache(store, cacheBytes(memory, job.speed.memory_bytes, store.path()), readers, skip);
  RenderResult result;
  result.camera = cameraFor(job.picture, store);
  result.transfer_function = transferFunctionFor(job.picture, store);
  FrameRequest request = frameRequest(job, result.camera, result.transfer_function);
  request.sweep_px = memory.sweep_px;
  request.band_px = memory.band_px;

  RenderStatistics& statistics = result.statistics;
  for (int i = 0; i < repeat; ++i) {
    FrameStatistics frame;
    result.image = Image();  // the picture before is not held while the next is drawn
    result.image = renderFrame(store, cache, request, progress, frame);
    statistics.frames.push_back(frame);
    statistics.load_s += frame.load_s;
    statistics.render_s += frame.wall_s - frame.load_s;
    progress.advance("rendering", "frames", static_cast<std::uint64_t>(i) + 1, static_cast<std::uint64_t>(repeat));
  }
  if (const std::uint64_t damaged = statistics.frames.back().bricks_damaged)
    progress.note(
        fmt::format("warning: {} damaged brick{} missing from the picture; kiln verify names all of the store's",
                    damaged, damaged == 1 ? " is" : "s are"));
  if (!job.output.path.empty()) {
    const auto begin = std::chrono::steady_clock::now();
    writePicture(job, result, request.view);
    statistics.output_s = secondsSince(begin);
  }
  statistics.budget_bytes = job.speed.memory_bytes;
  statistics.cache_bytes = cache.budgetBytes();
  statistics.peak_cache_bytes = cache.peakBytes();
  statistics.framebuffer_bytes = memory.image + memory.band;
  statistics.visibility_bytes = memory.visibility;
  statistics.index_bytes = memory.index;
  statistics.slabs_bytes = memory.slabs;
  for (const FrameStatistics& frame : statistics.frames)
    statistics.peak_slabs_bytes = std::max(statistics.peak_slabs_bytes, frame.slab_bytes);
  statistics.peak_rss_bytes = peakResidentBytes();
  return result;
}

}  // namespace kiln
