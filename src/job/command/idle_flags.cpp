#include "job/command/idle_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "base/file/file.h"
#include "job/job_facts.h"
#include "scene/camera/camera_path.h"

namespace kiln {
namespace {

// Returns whether a file of the job has one of these endings. A job without files writes all kinds: it is a dry run.
bool writes(const RenderJob& job, std::initializer_list<std::string_view> endings) {
  const std::vector<std::filesystem::path> files = namesOf(job.output);
  const auto has_ending = [&](const std::filesystem::path& path) {
    return std::find(endings.begin(), endings.end(), extensionOf(path)) != endings.end();
  };
  return files.empty() || std::any_of(files.begin(), files.end(), has_ending);
}

bool writesExr(const RenderJob& job) { return writes(job, {".exr"}); }
bool writesPng(const RenderJob& job) { return writes(job, {".png"}) || !job.output.video.path.empty(); }
bool writesJpeg(const RenderJob& job) { return writes(job, {".jpg", ".jpeg"}); }
bool composites(const RenderJob& job) { return job.picture.mode == Mode::kComposite; }
bool hasLight(const RenderJob& job) {
  const auto is_lit = [&](const VolumeOptions& volume) { return volume.shading.value_or(job.picture.shading).phong; };
  return job.picture.shading.phong || std::any_of(job.volumes.begin(), job.volumes.end(), is_lit);
}
bool fitsCamera(const RenderJob& job) { return isFramed(job.animation.camera, job.picture.camera); }
bool attenuates(const RenderJob& job) { return job.picture.mode == Mode::kAttenuatedMip; }
bool hasLens(const RenderJob& job) { return job.picture.lens.aperture > 0; }
bool hasLegend(const RenderJob& job) { return job.picture.annotations.legend; }
bool hasScaleBar(const RenderJob& job) { return job.picture.annotations.scale_bar; }
bool hasAnnotations(const RenderJob& job) { return job.picture.annotations.any(); }
bool approximates(const RenderJob& job) { return job.speed.visibility.method == VisibilityMethod::kQuadtree; }

// What an option applies to.
struct Need {
  bool (*met)(const RenderJob&);
  std::string_view text;
};
constexpr Need kNeedsExr = {writesExr, "EXR pictures (none is written)"};
constexpr Need kNeedsPng = {writesPng, "PNG pictures (none is written)"};
constexpr Need kNeedsJpeg = {writesJpeg, "JPEG pictures (none is written)"};
constexpr Need kNeedsComposite = {composites, "--mode composite (found a projection)"};
constexpr Need kNeedsPhong = {hasLight, "--shading phong (found none)"};
constexpr Need kNeedsFraming = {fitsCamera, "cameras that frame the volume (found an eye or matrices)"};
constexpr Need kNeedsAttenuation = {attenuates, "--mode attenuated-mip (found another mode)"};
constexpr Need kNeedsLens = {hasLens, "depth of field (found no --aperture)"};
constexpr Need kNeedsLegend = {hasLegend, "a legend (found no --legend)"};
constexpr Need kNeedsScaleBar = {hasScaleBar, "a scale bar (found no --scale-bar)"};
constexpr Need kNeedsAnnotations = {hasAnnotations, "annotations (none is drawn)"};
constexpr Need kNeedsQuadtree = {approximates, "--visibility quadtree (found another method)"};
constexpr Need kNeedsNothing = {[](const RenderJob&) { return true; }, ""};

struct IdleRow {
  std::string_view flag;
  Need need, also = kNeedsNothing;  // the first that is unmet is reported
};
constexpr IdleRow kIdleRows[] = {
    {"--exr-type", kNeedsExr},
    {"--compression", kNeedsExr},
    {"--exr-statistics", kNeedsExr},
    {"--png-bits", kNeedsPng},
    {"--jpeg-quality", kNeedsJpeg},
    {"--shading", kNeedsComposite},
    {"--tone", kNeedsComposite},
    {"--opacity-threshold", kNeedsComposite},
    {"--ambient", kNeedsComposite, kNeedsPhong},
    {"--diffuse", kNeedsComposite, kNeedsPhong},
    {"--specular", kNeedsComposite, kNeedsPhong},
    {"--power", kNeedsComposite, kNeedsPhong},
    {"--shadows", kNeedsComposite, kNeedsPhong},
    {"--ambient-occlusion", kNeedsComposite, kNeedsPhong},
    {"--light", kNeedsComposite, kNeedsPhong},
    {"--fit", kNeedsFraming},
    {"--attenuation", kNeedsAttenuation},
    {"--aperture-eyes", kNeedsLens},
    {"--legend-title", kNeedsLegend},
    {"--legend-position", kNeedsLegend},
    {"--scale-bar-length", kNeedsScaleBar},
    {"--annotation-color", kNeedsAnnotations},
    {"--annotation-size", kNeedsAnnotations},
    {"--quadtree-epsilon", kNeedsQuadtree},
};

}  // namespace

std::vector<std::string> idleFlags(const GivenFlags& flags, const RenderJob& job) {
  std::vector<std::string> out;
  for (const auto& [flag, need, also] : kIdleRows) {
    const Need& first = need.met(job) ? also : need;
    if (flags.has(flag) && !first.met(job))
      out.push_back(fmt::format("{}: has no effect here; applies to {}", flag, first.text));
  }
  return out;
}

}  // namespace kiln
