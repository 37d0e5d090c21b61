#include "sequence/dry_run.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/thread/parallel.h"
#include "frame/empty_frame.h"
#include "frame/light/light_plan.h"
#include "frame/pass/frame_progress.h"
#include "job/frame/frame_scene.h"
#include "job/job_facts.h"
#include "sequence/frame_annotations.h"
#include "sequence/frame_requests.h"
#include "sequence/opened_job.h"
#include "sequence/sequence.h"
#include "sequence/series_volumes.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"
#include "traverse/brick_walk.h"

namespace kiln {
namespace {

struct BrickSums {
  std::uint64_t bricks = 0, files = 0, file_bytes = 0, decoded_bytes = 0;
};

// Counts each brick once.
BrickSums sumsOf(std::vector<StoredBrick> seen, const std::vector<const BrickedVolume*>& volumes) {
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  BrickSums out;
  for (const StoredBrick& brick : seen) {
    const BrickedVolume& volume = *volumes[static_cast<std::size_t>(brick.store)];
    const BrickEntry& entry = volume.index().at(brick.key);
    ++out.bricks;
    out.files += entry.constant ? 0 : 1;
    out.file_bytes += entry.file_bytes;
    out.decoded_bytes += volume.blockBytes(brick.key);
  }
  return out;
}

// Keeps warnings and leaves out all other reports.
class KeptWarnings : public SilentProgress {
 public:
  KeptWarnings(const Progress& progress, std::vector<Doubt>& doubts) : SilentProgress(progress), doubts_(doubts) {}
  void warn(const std::string& sentence) override { doubts_.push_back({sentence, sentence}); }

 private:
  std::vector<Doubt>& doubts_;
};

}  // namespace

DryRun dryRun(const RenderJob& given, const MemoryBeside& beside) {
  RenderJob job = jobAtFrame(given, framesOf(given).front());
  if (!job.series) job.series = seriesLook(given, {});
  RenderJob unbounded = job;
  unbounded.speed.memory_bytes = UINT64_MAX;
  DryRun out = dryRun(job, OpenedVolumes(unbounded), beside);
  const ThreadLimit threads(job.speed.threads);
  if (writesBehind(given)) out.memory.behind = writeBehindBytes(out.memory, job);
  return out;
}

DryRun dryRun(const RenderJob& given, const OpenedVolumes& opened, const MemoryBeside& beside,
              const Progress& progress) {
  RenderJob job = given;
  job.picture.aovs = drawnAovs(job);
  const ThreadLimit threads(job.speed.threads);
  const std::vector<const BrickedVolume*>& volumes = opened.all();
  FitReads fit;
  DryRun out;
  KeptWarnings warnings(progress, out.doubts);
  const SceneOfJob scenes(job, opened.manifests(), sceneInputsOf(job, opened, fit, warnings), progress);
  out.memory = memoryOf(job, volumes, scenes, beside, progress);
  out.budget_bytes = job.speed.memory_bytes;
  BrickWalkCounts counts;
  std::vector<StoredBrick> bricks;
  FrameScene scene = scenes.at(framesOf(job).front());
  const FrameScene whole = scene;
  out.samples = scenes.mostSamples(progress);
  for (const PictureOptions& picture : eyesOf(scene.picture)) {
    progress.throwIfCancelled("counting bricks");
    scene.picture = picture;
    const std::vector<StoredBrick> seen = bricksInView(volumes, requestOf(scene, job.speed), counts);
    bricks.insert(bricks.end(), seen.begin(), seen.end());
  }
  // Both eyes see most bricks.
  const BrickSums in_view = sumsOf(std::move(bricks), volumes);
  out.bricks_in_view = in_view.bricks, out.files_in_view = in_view.files;
  out.file_bytes_in_view = in_view.file_bytes, out.decoded_bytes_in_view = in_view.decoded_bytes;
  // Maps of lights see most bricks of the picture, and bricks behind, beside and in front of its frame.
  std::vector<StoredBrick> of_lights;
  BrickWalkCounts ignored;
  for (const FrameRequest& request : lightRequests(volumes, requestOf(whole, job.speed))) {
    progress.throwIfCancelled("counting bricks of lights");
    const std::vector<StoredBrick> seen = bricksInView(volumes, request, ignored);
    of_lights.insert(of_lights.end(), seen.begin(), seen.end());
  }
  const BrickSums by_lights = sumsOf(std::move(of_lights), volumes);
  out.bricks_of_lights = by_lights.bricks, out.files_of_lights = by_lights.files;
  out.file_bytes_of_lights = by_lights.file_bytes;
  out.empty = emptinessOf(out.bricks_in_view > 0, whole, requestOf(whole, job.speed), opened.manifests());
  out.one_colour = isOfOneColour(whole, opened.manifests());
  warnOfLostAnnotations(whole, warnings);
  const std::vector<Doubt> doubts = doubtsOf(job, opened, scenes);
  out.doubts.insert(out.doubts.end(), doubts.begin(), doubts.end());
  out.bricks_interesting = counts.interesting;
  out.bricks_total = counts.bricks;
  return out;
}

std::string dryRunText(const DryRun& run) {
  const nlohmann::ordered_json out = {{"dry_run", true},
                                      {"samples", run.samples},
                                      {"bricks",
                                       {{"total", run.bricks_total},
                                        {"interesting", run.bricks_interesting},
                                        {"in_view", run.bricks_in_view},
                                        {"files_in_view", run.files_in_view},
                                        {"file_bytes_in_view", run.file_bytes_in_view},
                                        {"decoded_bytes_in_view", run.decoded_bytes_in_view},
                                        {"of_lights", run.bricks_of_lights},
                                        {"files_of_lights", run.files_of_lights},
                                        {"file_bytes_of_lights", run.file_bytes_of_lights}}},
                                      {"memory",
                                       {{"budget_bytes", run.budget_bytes},
                                        {"smallest_bytes", run.memory.smallest()},
                                        {"framebuffer_bytes", run.memory.framebuffer()},
                                        {"visibility_bytes", run.memory.visibility},
                                        {"shadows_bytes", run.memory.shadows},
                                        {"slabs_bytes", run.memory.slabs},
                                        {"trace_bytes", run.memory.trace},
                                        {"functions_bytes", run.memory.functions},
                                        {"index_bytes", run.memory.index},
                                        {"files_bytes", run.memory.files},
                                        {"threads_bytes", run.memory.threads},
                                        {"brick_bytes", run.memory.brick}}}};
  return out.dump(1) + "\n";
}

}  // namespace kiln
