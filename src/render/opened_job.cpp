#include "render/opened_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/span.h"
#include "render/render_job_run.h"

namespace kiln {
namespace {

RenderJob withDrawnAovs(RenderJob job) {
  job.picture.aovs = drawnAovs(job);
  return job;
}

// One thread reads nothing ahead, so that its statistics repeat.
unsigned readersOfCache() { return ThreadLimit::active() > 1 ? ThreadLimit::active() : 0; }

BrickCache::SkipHandler skipperOf(const RenderJob& job, Progress& progress) {
  if (!job.picture.skip_damaged) return {};
  return [&progress](const Error& damage) { progress.note(std::string("warning: drawn without ") + damage.what()); };
}

}  // namespace

Aovs aovsOf(const RenderJob& job, const OutputFile& file) {
  switch (file.content) {
    case Content::kPicture:
      return job.picture.aovs;
    case Content::kColor:
      return {};
    case Content::kDepth:
      return {true, false};
    case Content::kNormal:
      return {false, true};
    case Content::kValue:
      return {false, false, true};
  }
  return {};
}

Aovs drawnAovs(const RenderJob& job) {
  Aovs out = job.picture.aovs;
  for (const OutputFile& file : job.output.files) {
    const Aovs held = aovsOf(job, file);
    out.depth = out.depth || held.depth;
    out.normal = out.normal || held.normal;
    out.value = out.value || held.value;
  }
  return out;
}

OpenedJob::OpenedJob(const RenderJob& job, Progress& progress)
    : job_(job),
      drawn_job_(withDrawnAovs(job)),
      store_(job_.volume),
      memory_(frameMemory(store_, drawn_job_)),
      cache_(store_, cacheBytes(memory_, job_.speed.memory_bytes, store_.path()), readersOfCache(),
             skipperOf(job_, progress)),
      scenes_(drawn_job_, store_.manifest()) {}

DrawnFrame OpenedJob::draw(int frame, Progress& progress) {
  Span span(Activity::kFrame);
  if (span.traced()) span.note("frame", static_cast<std::uint64_t>(frame));
  DrawnFrame out;
  out.scene = sceneAt(frame);
  FrameRequest request = frameRequest(out.scene.picture, job_.speed, out.scene.camera, out.scene.transfer_function);
  request.sweep_px = memory_.sweep_px;
  request.band_px = memory_.band_px;
  out.view = request.view;
  out.image = renderFrame(store_, cache_, request, progress, out.statistics);
  out.statistics.frame = frame;
  out.statistics.peak_cache_bytes = cache_.peakBytes();
  out.statistics.peak_rss_bytes = peakResidentBytes();
  return out;
}

void noteDamage(const FrameStatistics& frame, Progress& progress) {
  const std::uint64_t damaged = frame.bricks_damaged;
  if (damaged == 0) return;
  progress.note(
      fmt::format("warning: {} damaged brick{} missing from the picture; kiln verify names all of the store's", damaged,
                  damaged == 1 ? " is" : "s are"));
}

void OpenedJob::describeMemory(RenderStatistics& statistics) const {
  statistics.budget_bytes = job_.speed.memory_bytes;
  statistics.cache_bytes = cache_.budgetBytes();
  statistics.peak_cache_bytes = std::max(statistics.peak_cache_bytes, cache_.peakBytes());
  statistics.peak_rss_bytes = peakResidentBytes();
  statistics.framebuffer_bytes = memory_.image + memory_.band;
  statistics.visibility_bytes = memory_.visibility;
  statistics.index_bytes = memory_.index;
  statistics.slabs_bytes = memory_.slabs;
  statistics.trace_bytes = memory_.trace;
}

}  // namespace kiln
