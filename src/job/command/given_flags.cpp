#include "job/command/given_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "base/error.h"
#include "job/job_facts.h"
#include "job/quality.h"

namespace kiln {
namespace {

// A missing --interocular is refused where the distance of the volume is known (SceneOfJob).
void requireStereo(const GivenFlags& flags, const std::optional<Stereo>& of_job) {
  if (!of_job && !flags.has("--stereo") && flags.hasAny({"--interocular", "--convergence"}))
    throw Error(ErrorCode::kUsage, "--interocular, --convergence: no pair is drawn; add --stereo both, left or right");
}

void requireStillCamera(const GivenFlags& flags, const RenderJob& job) {
  const bool keys = std::holds_alternative<CameraKeyframes>(job.animation.camera);
  const bool matrices = std::holds_alternative<CameraMatrices>(job.animation.camera);
  if ((!keys && !matrices) || flags.has("--turntable")) return;
  for (const char* flag : {"--camera", "--eye", "--target", "--up", "--view", "--azimuth", "--elevation", "--zoom"}) {
    if (flags.has(flag))
      throw Error(ErrorCode::kUsage, fmt::format("{}: the job says by {} where the camera is in each frame; change it "
                                                 "there, or give --turntable",
                                                 flag, keys ? "keyframes" : "matrices"));
  }
  for (const char* flag : {"--fov", "--height"}) {
    if (keys && flags.has(flag))
      throw Error(ErrorCode::kUsage, fmt::format("{}: the job says by keyframes where the camera is in each frame; "
                                                 "change it there, or give --turntable",
                                                 flag));
  }
}

// A given camera file replaces the camera of the job, a given view its eye, and a given eye its framing.
void replaceCamera(const GivenFlags& flags, CameraSpec& camera) {
  if (flags.has("--camera")) {
    camera = {};
  } else if (flags.has("--view") && !flags.has("--eye") && camera.eye) {
    CameraSpec framed;
    framed.projection = camera.projection;
    framed.fov_deg = camera.fov_deg;
    camera = framed;
  } else if (flags.has("--eye") && !flags.has("--view")) {
    camera.side.reset();
    camera.azimuth_deg.reset();
    camera.elevation_deg.reset();
    camera.zoom.reset();
  }
}

}  // namespace

std::string nameOfFlag(std::string_view flag) { return std::string(flag.substr(flag.rfind(',') + 1)); }

bool GivenFlags::hasAny(std::initializer_list<std::string_view> flags) const {
  return std::any_of(flags.begin(), flags.end(), [&](std::string_view flag) { return has(flag); });
}

std::optional<std::string> GivenFlags::text(std::string_view flag) const {
  for (const Given& given : given_) {
    if (nameOfFlag(given.flag->flag) == flag) return given.texts.empty() ? "" : given.texts.front();
  }
  return std::nullopt;
}

std::optional<std::string> GivenFlags::otherThan(std::initializer_list<std::string_view> flags) const {
  for (const Given& given : given_) {
    std::string name = nameOfFlag(given.flag->flag);
    if (std::find(flags.begin(), flags.end(), name) == flags.end()) return name;
  }
  return std::nullopt;
}

void GivenFlags::apply(RenderJob& job) const {
  for (const auto& [flag, texts] : given_) flag->apply(texts, job);
}

void applyGiven(const GivenFlags& flags, RenderJob& job) {
  requireStillCamera(flags, job);
  requireStereo(flags, job.picture.stereo);
  replaceCamera(flags, job.picture.camera);
  const PictureOptions before = job.picture;
  flags.apply(job);
  if (job.quality && !flags.hasAny({"--sample-distance", "--level"})) followEngine(*job.quality, before, job.picture);
  for (Key<Stereo>& key : job.animation.stereo) {
    if (flags.has("--interocular")) key.value.interocular = job.picture.stereo->interocular;
    if (flags.has("--convergence")) key.value.convergence = job.picture.stereo->convergence;
  }
  if (!job.states_size && !flags.has("--size")) job.picture.size = defaultSize(job);
  drawnPixels(job.picture.size, job.picture.crop);
  requireEngineOptions(job.picture);
}

void addVolumes(const AddedVolumes& more, const GivenFlags& flags, RenderJob& job) {
  const std::size_t count = more.added.size() + more.labels.size();
  if (more.functions.size() > count)
    throw Error(ErrorCode::kUsage,
                fmt::format("--add-tf: {} given for {} volumes of --add and --labels; the first is of the first",
                            more.functions.size(), count));
  if (job.volumes.empty() && count == 0) return;
  const bool had_volumes = !job.volumes.empty();
  if (!had_volumes) makeFirstOfSeveral(job);
  VolumeOptions& first = job.volumes.front();
  if (flags.has("--tf")) {
    first.transfer_function = job.picture.transfer_function;
    first.functions.clear();
  }
  if (flags.has("--window")) first.window = job.picture.window;
  if (auto mask = std::exchange(job.companions.mask, std::nullopt)) first.companions.mask = std::move(mask);
  if (auto colors = std::exchange(job.companions.color_by, std::nullopt)) first.companions.color_by = std::move(colors);
  if (auto region = std::exchange(job.picture.clipping.region, std::nullopt)) first.clipping.region = region;
  if (had_volumes && flags.has("--section"))
    first.clipping.section = std::exchange(job.picture.clipping.section, std::nullopt);
  for (std::size_t i = 0; i < count; ++i) {
    VolumeOptions volume;
    volume.labels = i >= more.added.size();
    volume.volume = volume.labels ? more.labels[i - more.added.size()] : more.added[i];
    if (i < more.functions.size()) volume.transfer_function = more.functions[i];
    job.volumes.push_back(std::move(volume));
  }
}

}  // namespace kiln
