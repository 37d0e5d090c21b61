// Reads a job by its table of options, and checks options against each other.
#include "job/render_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "base/error.h"
#include "base/file/file.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kLargestJob_bytes = 16u << 20;

// Calls change(path) for the file of each companion.
template <class Job, class Change>
void forEachCompanion(Job& job, const Change& change) {
  const auto each = [&](auto& companions) {
    if (companions.mask) change(companions.mask->volume);
    if (companions.color_by) change(companions.color_by->volume);
  };
  for (auto& volume : job.volumes) each(volume.companions);
  each(job.companions);
}

}  // namespace

OutputOptions encodingsOf(const OutputOptions& output) {
  OutputOptions out = output;
  out.path.clear();
  out.files.clear();
  out.video = {};
  out.deep = false;
  return out;
}

std::vector<fs::path> namesOf(const OutputOptions& output) {
  std::vector<fs::path> out{output.path};
  for (const OutputFile& file : output.files) out.push_back(file.path);
  out.push_back(output.video.path);
  std::erase_if(out, [](const fs::path& name) { return name.empty(); });
  return out;
}

std::vector<fs::path> volumesOf(const RenderJob& job) {
  std::vector<fs::path> out;
  for (const VolumeOptions& volume : job.volumes) out.push_back(volume.volume);
  if (out.empty()) out.push_back(job.volume);
  return out;
}

std::vector<fs::path> inputVolumesOf(const RenderJob& job) {
  std::vector<fs::path> out = volumesOf(job);
  forEachCompanion(job, [&](const fs::path& volume) { out.push_back(volume); });
  return out;
}

void forEachVolume(RenderJob& job, const std::function<fs::path(const fs::path&)>& change) {
  for (VolumeOptions& volume : job.volumes) volume.volume = change(volume.volume);
  job.volume = job.volumes.empty() ? change(job.volume) : job.volumes.front().volume;
  forEachCompanion(job, [&](fs::path& volume) { volume = change(volume); });
}

bool namesRelatively(const RenderJob& job) {
  return std::ranges::any_of(inputVolumesOf(job),
                             [](const fs::path& volume) { return !volume.empty() && volume.is_relative(); });
}

Shading shadingOf(const RenderJob& job) {
  Shading out = job.picture.shading;
  if (!job.animation.lights.empty()) out.lights = job.animation.lights.front().value;
  return out;
}

bool isVideo(const fs::path& path) {
  const std::string ending = extensionOf(path);
  return ending == ".mp4" || ending == ".mov" || ending == ".mkv" || ending == ".webm";
}

void putOutput(const fs::path& path, OutputOptions& output) {
  (isVideo(path) ? output.video.path : output.path) = path;
}

Background backgroundOf(const PictureOptions& picture, const TransferFunction& transfer_function) {
  if (picture.background) return *picture.background;
  if (engineOf(picture).capabilities().composites) return {};
  const glm::dvec3 color = transfer_function.at(-std::numeric_limits<double>::infinity()).color;
  const std::array<double, 4> opaque{color.r, color.g, color.b, 1};
  return {opaque, opaque};
}

Display displayOf(const PictureOptions& picture) {
  Display out = picture.display;
  if (!engineOf(picture).capabilities().composites) out.tone = Tone::kClip;
  return out;
}

bool samplesKnown(int samples) { return samples == 1 || samples == 2 || samples == 4 || samples == 16; }

bool oversamples(const PictureOptions& picture) { return picture.samples.value_or(1) != 1; }

int subPixelsAlongEdge(int samples) {
  if (!samplesKnown(samples))
    throw Error(ErrorCode::kUsage, fmt::format("--samples: expected 1, 2, 4 or 16 a pixel, found {}", samples));
  return samples == 1 ? 1 : samples <= 4 ? 2 : 4;
}

EngineChoice engineOf(const PictureOptions& picture) { return {picture.mode, picture.lattice, false}; }

EngineChoice engineOf(const RenderJob& job) { return {job.picture.mode, job.picture.lattice, !job.volumes.empty()}; }

void requireEngineOptions(const PictureOptions& picture) {
  requireOptions(engineOf(picture), {picture.interpolation, picture.samples.value_or(1), picture.sample_distance,
                                     picture.aovs, picture.coarser});
}

ImageSize defaultSize(const RenderJob& job) {
  return projectionOf(job) == Projection::kEquirectangular ? kPanoramaSize : ImageSize();
}

Projection projectionOf(const RenderJob& job) {
  const auto* const path = std::get_if<CameraKeyframes>(&job.animation.camera);
  const std::optional<Projection> of_key = path ? path->keys.front().value.projection : std::nullopt;
  return of_key.value_or(job.picture.camera.projection.value_or(Projection::kPerspective));
}

bool drawsPart(const PictureOptions& picture) { return picture.part || picture.clipping.part; }

void requirePart(const RenderJob& job) {
  if (!drawsPart(job.picture)) return;
  requireCapability(engineOf(job), &EngineCapabilities::parts, "--part: needs",
                    "draw one volume, with --mode composite");
  const OutputOptions& output = job.output;
  const std::filesystem::path& file = output.video.path.empty() ? output.path : output.video.path;
  if (!file.empty() && extensionOf(file) != ".exr")
    throw Error(ErrorCode::kUsage,
                fmt::format("--part: -o of a partial image ends in .exr (found {}); choose a name of "
                            "an EXR, whose header has the image's place",
                            file.string()));
  if (!output.files.empty())
    throw Error(ErrorCode::kUsage, fmt::format("--part: a partial image is one file, -o (found {} in outputs); leave "
                                               "outputs out",
                                               output.files.size()));
}

void requireVolumes(const RenderJob& job) {
  if (job.volumes.size() > kMostVolumesOfJob)
    throw Error(ErrorCode::kUsage, fmt::format("volumes: at most {} in one picture (found {}); draw fewer",
                                               kMostVolumesOfJob, job.volumes.size()));
  if (!job.volumes.empty()) requireOptions(engineOf(job), {});
  requireCompanions(job);
  requireSections(job);
  requireChannels(job);
}

void requireCompanions(const RenderJob& job) {
  const auto require = [&](const Companions& companions) {
    if (companions.mask)
      requireCapability(engineOf(job), &EngineCapabilities::companions, "--mask: needs", "leave --mask out");
    if (companions.color_by)
      requireCapability(engineOf(job), &EngineCapabilities::companions, "--color-by: needs", "leave --color-by out");
  };
  require(job.companions);
  for (const VolumeOptions& volume : job.volumes) require(volume.companions);
}

void requireSections(const RenderJob& job) {
  const bool moves = !job.animation.clip.empty();
  const auto require = [&](const Clipping& clipping, bool cut) {
    if (!clipping.section) return;
    requireCapability(engineOf(job), &EngineCapabilities::sections, "--section: needs", "leave --section out");
    if (!cut && !clipping.region && clipping.planes.empty())
      throw Error(ErrorCode::kUsage,
                  "--section: nothing is cut; add --clip, --region or --world-region, or leave --section out");
  };
  require(job.picture.clipping, moves);
  for (const VolumeOptions& volume : job.volumes)
    require(volume.clipping, moves || !job.picture.clipping.planes.empty());
}

void requireChannels(const RenderJob& job) {
  const std::size_t colors = job.picture.channel_colors.size(), volumes = job.volumes.size();
  if (colors == 0) return;
  if (volumes < 2 || engineOf(job).kind() != EngineKind::kProjection)
    throw Error(ErrorCode::kUsage,
                fmt::format("--channel-colors: needs --mode mip, minip, average or attenuated-mip of several volumes "
                            "(found {} of {}); leave it out",
                            engineOf(job).text(), volumes < 2 ? "one volume" : "several"));
  if (colors > volumes)
    throw Error(ErrorCode::kUsage,
                fmt::format("--channel-colors: at most one for each of {} volumes (found {})", volumes, colors));
}

void makeFirstOfSeveral(RenderJob& job) {
  PictureOptions& picture = job.picture;
  VolumeOptions first;
  first.volume = job.volume;
  first.transfer_function = picture.transfer_function;
  first.functions = std::exchange(job.animation.functions, {});
  first.window = picture.window;
  first.companions = std::exchange(job.companions, {});
  first.clipping.region = std::exchange(picture.clipping.region, std::nullopt);
  first.clipping.section = std::exchange(picture.clipping.section, std::nullopt);
  job.volumes = {std::move(first)};
}

bool moves(const RenderJob& job) {
  const auto has_keys = [](const VolumeOptions& volume) { return !volume.functions.empty(); };
  return job.animation.any() || std::any_of(job.volumes.begin(), job.volumes.end(), has_keys);
}

std::vector<int> framesOf(const RenderJob& job) {
  if (!job.frames.empty()) return job.frames;
  Animation all = job.animation;
  for (const VolumeOptions& volume : job.volumes)
    all.functions.insert(all.functions.end(), volume.functions.begin(), volume.functions.end());
  const std::vector<int> out = all.frames();
  if (out.empty())
    throw Error(ErrorCode::kUsage,
                "no whole frame is between the first keyframe and the last; keys are at frames such as 1 and 48");
  if (out.size() > kMostFrames)
    throw Error(ErrorCode::kUsage, fmt::format("the keyframes span {} frames, more than {}", out.size(), kMostFrames));
  return out;
}

RenderJob parseJob(const std::string& text, const fs::path& path) {
  const JobObject root = JobObject::parse(text, path);
  RenderJob job;
  readOptions(jobOptions(), root, job);
  if (!root.has("volume") && !root.has("volumes"))
    root.complain("volume", "is missing; a job names the store or volume file to draw");
  const auto image = root.object("image");
  job.states_size = image && (image->has("width") || image->has("height"));
  if (!job.states_size) job.picture.size = defaultSize(job);
  return job;
}

RenderJob readJob(const fs::path& path) { return parseJob(readTextFile(path, kLargestJob_bytes), path); }

}  // namespace kiln
