#include "sequence/opened_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/memory/spare_pages.h"
#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "engine/shown_box.h"
#include "frame/empty_frame.h"
#include "frame/hidden_section.h"
#include "frame/light/light_plan.h"
#include "frame/pass/frame_progress.h"
#include "job/job_facts.h"
#include "scene/transfer/label_styles.h"
#include "sequence/frame_annotations.h"
#include "sequence/frame_requests.h"
#include "sequence/render_job_run.h"
#include "store/manifest/float_steps.h"

namespace kiln {
namespace {

RenderJob withDrawnAovs(RenderJob job) {
  job.picture.aovs = drawnAovs(job);
  return job;
}

FrameMemory withBehind(FrameMemory memory, bool writes_behind, const RenderJob& job) {
  if (writes_behind) memory.behind = writeBehindBytes(memory, job);
  return memory;
}

// Volumes with companions are no plain stores, and are read by each rank for itself.
FrameMemory withShared(FrameMemory memory, std::uint64_t budget, const std::vector<const StoreReader*>& stores) {
  const std::uint64_t taken = memory.besideBricks() + memory.brick;
  if (!stores.empty() && taken < budget)
    memory.shared = SharedReads::shareOf(budget, budget - taken, SharedReads::largestFileOf(stores));
  return memory;
}

bool isAuto(const VolumeOptions& volume) {
  const auto* const name = std::get_if<std::string>(&volume.transfer_function);
  return volume.functions.empty() && name != nullptr && *name == "auto";
}

}  // namespace

Aovs aovsOf(const RenderJob& job, const OutputFile& file) {
  switch (file.content) {
    case Content::kPicture:
      return job.picture.aovs;
    case Content::kColor:
    case Content::kDeep:
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
  out.depth = out.depth || hidesOutline(job);
  return out;
}

std::vector<Doubt> doubtsOf(const RenderJob& job, const OpenedVolumes& volumes, const SceneOfJob& scenes) {
  std::vector<Doubt> out;
  const auto add = [&](std::size_t v, const std::string& sentence) {
    if (!sentence.empty())
      out.push_back({std::to_string(v) + " " + sentence, volumes.all()[v]->path().string() + ": " + sentence});
  };
  for (std::size_t v = 0; v < volumes.all().size(); ++v) {
    const Manifest& manifest = volumes.all()[v]->manifest();
    add(v, unknownLabelsText(scenes.functionsOf(v), manifest));
    add(v, mergedValuesText(manifest));
    add(v, manifest.assumption);
    if (v > 0 && isAuto(job.volumes[v])) add(v, likelyLabelsText(manifest));
    add(v, hiddenSectionText(scenes, framesOf(job), v, manifest.geometry()));
  }
  for (const std::string& assumption : volumes.assumptions()) out.push_back({assumption, assumption});
  const Shading shading = shadingOf(job);
  const bool lit = engineOf(job).capabilities().composites && shading.phong;
  if (lit && shading.shadows && std::none_of(shading.lights.begin(), shading.lights.end(), [&](const Light& light) {
        return castsShadows(shading, light);
      }))
    out.push_back({"headlights",
                   "--shadows: the eye sees no shadow of a headlight (found no other light); add a light, "
                   "such as --light cam:-1,1,1"});
  return out;
}

void warnOf(const std::vector<Doubt>& doubts, std::set<std::string>& doubted, Progress& progress) {
  for (const Doubt& doubt : doubts) {
    if (doubted.insert(doubt.kind).second) progress.warn(doubt.sentence);
  }
}

BrickCache::SkipHandler skipperOf(const RenderJob& job, Progress& progress) {
  if (!job.picture.skip_damaged) return {};
  return [&progress](const Error& damage) { progress.warn(std::string("drawn without ") + damage.what()); };
}

void judge(DrawnFrame& drawn, const FrameRequest& request, const OpenedVolumes& volumes) {
  if (drawn.continued) return;
  drawn.statistics.empty = emptinessOf(drawn.statistics, drawn.scene, request, volumes.manifests());
  drawn.statistics.one_colour = isOfOneColour(drawn.scene, volumes.manifests());
}

unsigned readersOfCache() { return ThreadLimit::active() > 1 ? ThreadLimit::active() : 0; }

FrameRequest requestOf(const FrameScene& scene, const SpeedOptions& speed, const FrameMemory& memory) {
  FrameRequest out = requestOf(scene, speed);
  out.bricks_together = memory.bricks_together;
  out.band_px = memory.band_px;
  return out;
}

FrameMemory memoryOf(RenderJob job, const std::vector<const BrickedVolume*>& stores, const SceneOfJob& scenes,
                     const MemoryBeside& beside, const Progress& progress) {
  job.picture.samples = scenes.mostSamples(progress);
  const PixelRect written = drawnPixels(job.picture.size, job.picture.crop);
  if (beside.at_a_time) job.picture.crop = beside.at_a_time;
  std::uint64_t least = 0;
  for (const BrickedVolume* const store : stores) least = std::max(least, store->largestReadBytes());
  if (!job.volumes.empty())
    least = std::max(least, bytesAtOnce(stores, requestOf(scenes.at(framesOf(job).front()), job.speed)));
  if (job.picture.shading.occlusion.strength > 0 && engineOf(job).capabilities().composites) {
    const FrameRequest request = requestOf(scenes.at(framesOf(job).front()), job.speed);
    for (const FrameRequest& along : latticeRequests(stores, request))
      least = std::max(least, bytesAtOnce(stores, along));
  }
  // Memory that the frame cannot choose is taken off before shares of the budget are computed.
  const std::uint64_t functions = scenes.functionBytes();
  job.speed.memory_bytes -= std::min(job.speed.memory_bytes, beside.bytes + functions);
  FrameMemory out = frameMemory(stores, job, least, beside.at_a_time ? std::optional(written) : std::nullopt);
  out.image += beside.bytes;
  out.functions = functions;
  return out;
}

SceneInputs sceneInputsOf(const RenderJob& job, const OpenedVolumes& volumes, FitReads& reads, Progress& progress) {
  if (job.picture.level) {
    for (const BrickedVolume* const volume : volumes.all()) volume->requireLevel(*job.picture.level);
  }
  const auto shown_box = [&](std::size_t volume, const std::vector<TransferFunction>& functions,
                             const Clipping& clipping) {
    const BrickedVolume& store = *volumes.all()[volume];
    std::vector<TransferFunction> in_world;
    for (const TransferFunction& function : functions)
      in_world.push_back(inWorld(function, store.manifest().world_per_own));
    ShownBox shown;
    try {
      shown = shownBox(store, in_world, clipping, true, progress);
    } catch (const Error& damage) {
      if (!job.picture.skip_damaged || damage.code() == ErrorCode::kUsage || damage.code() == ErrorCode::kCancelled)
        throw;
      progress.warn(fmt::format("the camera shows more than is visible: {}", damage.what()));
      shown = shownBox(store, in_world, clipping, false, progress);
    }
    reads.files += shown.files;
    reads.bytes += shown.file_bytes;
    const VolumeGeometry box = shown.box.empty() ? VolumeGeometry() : partOf(store.manifest().geometry(), shown.box);
    return FramedBox(box, std::move(shown.outline), Fit::kVisible);
  };
  return {shown_box, freeEdges, volumes.companions(), volumes.colorFunctions()};
}

OpenedJob::OpenedJob(const RenderJob& job, Progress& progress, const MemoryBeside& beside, SharedReads* shared,
                     bool writes_behind)
    : OpenedJob(job, OpenedVolumes(job), progress, beside, shared, writes_behind) {}

OpenedJob::OpenedJob(const RenderJob& job, OpenedVolumes volumes, Progress& progress, const MemoryBeside& beside,
                     SharedReads* shared, bool writes_behind)
    : job_(job),
      drawn_job_(withDrawnAovs(job)),
      volumes_(std::move(volumes)),
      scenes_(drawn_job_, volumes_.manifests(), sceneInputsOf(drawn_job_, volumes_, fit_, progress)),
      memory_(withShared(withBehind(memoryOf(drawn_job_, volumes_.all(), scenes_, beside), writes_behind, drawn_job_),
                         shared != nullptr ? job_.speed.memory_bytes : 0, volumes_.stores())),
      for_ranks_(shared, volumes_.stores(), memory_.shared),
      cache_(volumes_.all(), cacheBytes(memory_, job_.speed.memory_bytes, firstVolume().path()), readersOfCache(),
             skipperOf(job_, progress), for_ranks_.supplier()) {
  requireFont(job_);
  boundSparePages(sparePagesBytes(memory_, job_.speed.memory_bytes));
}

void OpenedJob::noteLook(Progress& progress) const {
  noteDeep(progress);
  notePaleFog(progress);
  warnOfLostAnnotations(scenes_.at(framesOf(job_).front()), progress);
}

void OpenedJob::notePaleFog(Progress& progress) const {
  const PictureOptions& picture = job_.picture;
  if (!job_.volumes.empty() || picture.background || !engineOf(picture).capabilities().composites) return;
  if (firstVolume().manifest().volume_class != VolumeClass::kFog) return;
  const auto* const preset = std::get_if<std::string>(&picture.transfer_function);
  if (preset == nullptr || (*preset != "auto" && *preset != "fog")) return;
  std::vector<std::filesystem::path> paths = {job_.output.path};
  for (const OutputFile& file : job_.output.files) paths.push_back(file.path);
  for (const std::filesystem::path& path : paths) {
    if (extensionOf(path) != ".png") continue;
    progress.note(
        fmt::format("{}: the fog is bright and the background transparent, which is pale on a white page; "
                    "--background black is dark, --background transparent leaves this note out",
                    path.string()));
    return;
  }
}

void OpenedJob::noteDeep(Progress& progress) const {
  const auto is_flat = [](const OutputFile& file) { return file.content != Content::kDeep; };
  const std::vector<OutputFile>& files = job_.output.files;
  if (!drawsDeep(job_) || std::any_of(files.begin(), files.end(), is_flat)) return;
  progress.note(fmt::format(
      "{}: a deep picture has one ray a pixel and no pixel filter, unlike a flat picture of the same options; a flat "
      "picture beside it (outputs) is the deep one, flattened",
      (files.empty() ? job_.output.path : files.front().path).string()));
}

FrameRequest OpenedJob::requestFor(const FrameScene& scene) const {
  FrameRequest request = requestOf(scene, job_.speed, memory_);
  volumes_.dress(request);
  if (drawsDeep(job_)) request.deep = job_.output.deep_bound;
  request.last_illumination = &shadows_;
  return request;
}

std::unique_ptr<FramePainter> OpenedJob::painterFor(const FrameScene& scene, Progress& progress) {
  return std::make_unique<FramePainter>(cache_, requestFor(scene), progress);
}

FrameStatistics OpenedJob::finish(FramePainter& painter, int frame) const {
  FrameStatistics out = painter.finish();
  out.frame = frame;
  out.peak_cache_bytes = cache_.peakBytes();
  out.peak_rss_bytes = peakResidentBytes();
  return out;
}

DrawnFrame OpenedJob::draw(int frame, Progress& progress) {
  const auto request_for = [this](const FrameScene& scene) { return requestFor(scene); };
  return drawFrame(cache_, sceneAt(frame), request_for, frame, progress);
}

DrawnFrame drawFrame(BrickCache& cache, const FrameScene& scene,
                     const std::function<FrameRequest(const FrameScene&)>& request_for, int frame, Progress& progress) {
  ProfileScope span(Activity::kFrame);
  if (span.traced()) span.note("frame", static_cast<std::uint64_t>(frame));
  DrawnFrame out;
  out.scene = scene;
  FrameScene seen = scene;
  std::vector<FrameRequest> eyes;
  for (const PictureOptions& picture : eyesOf(scene.picture)) {
    seen.picture = picture;
    eyes.push_back(request_for(seen));
  }
  FrameProgress of_frame(frame, stepsOfParts(cache.stores(), eyes), progress);
  for (const FrameRequest& request : eyes) {
    FrameStatistics statistics;
    out.views.push_back({renderFrame(cache, request, of_frame, statistics), request.view});
    out.statistics.addView(statistics);
  }
  out.statistics.frame = frame;
  out.statistics.peak_cache_bytes = cache.peakBytes();
  out.statistics.peak_rss_bytes = peakResidentBytes();
  return out;
}

void noteDamage(const FrameStatistics& frame, Progress& progress) {
  const std::uint64_t damaged = frame.bricks_damaged;
  if (damaged == 0) return;
  progress.warn(fmt::format("{} damaged brick{} missing from the picture; kiln verify names all of the store's",
                            damaged, damaged == 1 ? " is" : "s are"));
}

void OpenedJob::describeMemory(RenderStatistics& statistics) const {
  statistics.budget_bytes = job_.speed.memory_bytes;
  statistics.cache_bytes = cache_.budgetBytes();
  statistics.peak_cache_bytes = std::max(statistics.peak_cache_bytes, cache_.peakBytes());
  statistics.peak_rss_bytes = peakResidentBytes();
  statistics.framebuffer_bytes = memory_.framebuffer();
  statistics.visibility_bytes = memory_.visibility;
  statistics.index_bytes = memory_.index;
  statistics.files_bytes = memory_.files;
  statistics.threads_bytes = memory_.threads;
  statistics.shadows_bytes = memory_.shadows;
  statistics.slabs_bytes = memory_.slabs;
  statistics.trace_bytes = memory_.trace;
  statistics.functions_bytes = memory_.functions;
  statistics.shared_reads_bytes = memory_.shared;
  statistics.fit = fit_;
}

}  // namespace kiln
