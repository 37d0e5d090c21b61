#include "sequence/render_job_run.h"

#include <fmt/format.h>

#include <optional>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "base/thread/trace.h"
#include "frame/empty_frame.h"
#include "frame/pass/frame_progress.h"
#include "job/frame/frame_scene.h"
#include "job/job_facts.h"
#include "sequence/frame_files.h"
#include "sequence/opened_job.h"
#include "sequence/sequence.h"
#include "sequence/series_volumes.h"

namespace kiln {

namespace {

void requireDrawable(const RenderJob& job) {
  requirePart(job);
  requireVolumes(job);
  requireViews(job);
  requireOutputs(job, {framesOf(job).front()});
  requirePlaces(job, framesOf(job).front());
}

RenderResult drawFirstFrame(const RenderJob& job, OpenedJob& opened, int repeat, Progress& progress) {
  const int number = framesOf(job).front();
  for (const Doubt& doubt : opened.doubts()) progress.warn(doubt.sentence);
  opened.noteLook(progress);
  RenderResult result;
  DrawnFrame drawn;
  UncountedProgress of_one(progress);
  for (int i = 0; i < repeat; ++i) {
    drawn = {};  // frees the previous picture before the next is drawn
    drawn = opened.draw(number, repeat == 1 ? progress : of_one);
    opened.judge(drawn);
    if (i + 1 == repeat) writeFrame(job, number, drawn, opened.firstVolume(), opened.memory().files);
    result.statistics.add(drawn.statistics);
    progress.advance("rendering", "frames", static_cast<std::uint64_t>(i) + 1, static_cast<std::uint64_t>(repeat));
  }
  noteDamage(result.statistics.frames.back(), progress);
  warnOfDoubtfulFrames({result.statistics.frames.back()}, false, progress);
  opened.describeMemory(result.statistics);
  result.image = std::move(drawn.views.front().image);
  result.camera = drawn.scene.camera;
  result.transfer_function = drawn.scene.transfer_function;
  return result;
}

// `open` returns the opened job. The trace covers opening, drawing and writing.
template <class Open>
RenderResult runJob(const RenderJob& job, int repeat, Progress& progress, const Open& open) {
  if (repeat < 1)
    throw Error(ErrorCode::kUsage, fmt::format("repeat: expected 1 or more (found {}); draw the job once", repeat));
  requireDrawable(job);
  const ThreadLimit threads(job.speed.threads);
  std::optional<Trace> trace;
  if (!job.trace.empty()) trace.emplace(job.trace);
  OpenedJob opened = open();
  RenderResult result = drawFirstFrame(job, opened, repeat, progress);
  if (trace) trace->finish();
  return result;
}

}  // namespace

Camera cameraFor(const PictureOptions& picture, const BrickedVolume& volume) {
  return picture.camera.resolve(volume.manifest().geometry(), picture.size);
}

TransferFunction transferFunctionFor(const PictureOptions& picture, const BrickedVolume& volume) {
  return resolvedFor(picture, picture.transfer_function, volume.manifest());
}

RenderResult runRenderJob(const RenderJob& job, int repeat, Progress& progress) {
  return runJob(job, repeat, progress, [&] {
    RenderJob at_frame = jobAtFrame(job, framesOf(job).front());
    if (!at_frame.series) at_frame.series = seriesLook(job, {});
    return OpenedJob(at_frame, progress);
  });
}

RenderResult runRenderJob(const RenderJob& job, std::span<const BrickedVolume* const> volumes, Progress& progress) {
  return runJob(job, 1, progress, [&] { return OpenedJob(job, OpenedVolumes(job, volumes), progress); });
}

}  // namespace kiln
