#include "sequence/render_job_run.h"

#include <optional>

#include "base/thread/parallel.h"
#include "base/thread/trace.h"
#include "frame/empty_frame.h"
#include "frame/pass/frame_progress.h"
#include "job/frame_scene.h"
#include "sequence/frame_files.h"
#include "sequence/opened_job.h"
#include "sequence/sequence.h"
#include "sequence/series_volumes.h"

namespace kiln {

Camera cameraFor(const PictureOptions& picture, const StoreReader& store) {
  return picture.camera.resolve(store.manifest().geometry(), picture.size);
}

TransferFunction transferFunctionFor(const PictureOptions& picture, const StoreReader& store) {
  return resolvedFor(picture, picture.transfer_function, store.manifest());
}

FrameRequest frameRequest(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function) {
  return frameRequest(job.picture, job.speed, camera, transfer_function);
}

FrameRequest requestOf(const FrameScene& scene, const SpeedOptions& speed) {
  FrameRequest out = frameRequest(scene.picture, speed, scene.camera, scene.transfer_function);
  for (const VolumeScene& volume : scene.volumes)
    out.volumes.push_back({inWorld(volume.transfer_function, volume.world_per_own), volume.shading, volume.clipping});
  return out;
}

FrameRequest frameRequest(const PictureOptions& picture, const SpeedOptions& speed, const Camera& camera,
                          const TransferFunction& transfer_function) {
  FrameRequest request;
  request.view = resolve(camera, picture.stereo, picture.size);
  request.transfer_function = transfer_function;
  request.shading = picture.shading;
  request.clipping = picture.clipping;
  if (!drawsPart(picture)) request.background = backgroundOf(picture, transfer_function);
  request.opacity_threshold = picture.opacity_threshold;
  request.mode = picture.mode;
  request.lattice = picture.lattice;
  request.interpolation = picture.interpolation;
  request.sample_distance = picture.sample_distance;
  request.crop = picture.crop;
  request.samples = picture.samples.value_or(1);
  request.aovs = picture.aovs;
  request.level = picture.level;
  request.coarser = picture.coarser;
  request.visibility = speed.visibility;
  request.tile_px = speed.tile_px;
  return request;
}

RenderResult runRenderJob(const RenderJob& job, int repeat, Progress& progress) {
  requirePart(job);
  requireVolumes(job);
  requireViews(job);
  requireOutputs(job, {framesOf(job).front()});
  const ThreadLimit threads(job.speed.threads);
  std::optional<Trace> trace;
  if (!job.trace.empty()) trace.emplace(job.trace);
  const int number = framesOf(job).front();
  requirePlaces(job, number);
  RenderJob at_frame = jobAtFrame(job, number);
  if (!at_frame.series) at_frame.series = seriesLook(job, {});
  OpenedJob opened(at_frame, progress);
  for (const OpenedJob::Doubt& doubt : opened.doubts()) progress.warn(doubt.sentence);
  opened.noteDeep(progress);
  RenderResult result;
  DrawnFrame drawn;
  UncountedProgress of_one(progress);
  for (int i = 0; i < repeat; ++i) {
    drawn = {};  // frees the previous picture before the next is drawn
    drawn = opened.draw(number, repeat == 1 ? progress : of_one);
    opened.judge(drawn);
    if (i + 1 == repeat) writeFrame(job, number, drawn, opened.store(), opened.memory().files);
    result.statistics.add(drawn.statistics);
    progress.advance("rendering", "frames", static_cast<std::uint64_t>(i) + 1, static_cast<std::uint64_t>(repeat));
  }
  noteDamage(result.statistics.frames.back(), progress);
  warnOfDoubtfulFrames({result.statistics.frames.back()}, false, progress);
  opened.describeMemory(result.statistics);
  result.image = std::move(drawn.views.front().image);
  result.camera = drawn.scene.camera;
  result.transfer_function = drawn.scene.transfer_function;
  if (trace) trace->finish();
  return result;
}

}  // namespace kiln
