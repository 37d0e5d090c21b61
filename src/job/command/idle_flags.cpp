#include "job/command/idle_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <span>
#include <string_view>

#include "base/file/file.h"
#include "job/job_facts.h"

namespace kiln {
namespace {

// Returns whether a file of the job has one of these endings. A job without files writes all kinds: it is a dry run.
bool writes(const RenderJob& job, std::initializer_list<std::string_view> endings) {
  bool named = false, found = false;
  for (const std::filesystem::path& path : namesOf(job.output)) {
    named = true;
    found = found || std::find(endings.begin(), endings.end(), extensionOf(path)) != endings.end();
  }
  return !named || found;
}

bool writesExr(const RenderJob& job) { return writes(job, {".exr"}); }
bool writesPng(const RenderJob& job) { return writes(job, {".png"}) || !job.output.video.path.empty(); }
bool writesJpeg(const RenderJob& job) { return writes(job, {".jpg", ".jpeg"}); }
bool composites(const RenderJob& job) { return job.picture.mode == Mode::kComposite; }
bool hasLight(const RenderJob& job) {
  const auto is_lit = [&](const VolumeOptions& volume) { return volume.shading.value_or(job.picture.shading).phong; };
  return job.picture.shading.phong || std::any_of(job.volumes.begin(), job.volumes.end(), is_lit);
}
bool attenuates(const RenderJob& job) { return job.picture.mode == Mode::kAttenuatedMip; }
bool hasLens(const RenderJob& job) { return job.picture.lens.aperture > 0; }
bool hasLegend(const RenderJob& job) { return job.picture.annotations.legend; }
bool hasAnnotations(const RenderJob& job) { return job.picture.annotations.any(); }
bool approximates(const RenderJob& job) { return job.speed.visibility.method == VisibilityMethod::kQuadtree; }

constexpr std::array<std::string_view, 3> kOfExr = {"--exr-type", "--compression", "--exr-statistics"};
constexpr std::array<std::string_view, 1> kOfPng = {"--png-bits"};
constexpr std::array<std::string_view, 1> kOfJpeg = {"--jpeg-quality"};
constexpr std::array<std::string_view, 10> kOfOpacity = {
    "--shading", "--ambient",           "--diffuse", "--specular",          "--power",
    "--shadows", "--ambient-occlusion", "--light",   "--opacity-threshold", "--tone"};
constexpr std::array<std::string_view, 7> kOfLight = {"--ambient", "--diffuse",           "--specular", "--power",
                                                      "--shadows", "--ambient-occlusion", "--light"};
constexpr std::array<std::string_view, 1> kOfAttenuation = {"--attenuation"};
constexpr std::array<std::string_view, 1> kOfLens = {"--aperture-eyes"};
constexpr std::array<std::string_view, 1> kOfLegend = {"--legend-title"};
constexpr std::array<std::string_view, 2> kOfAnnotations = {"--annotation-color", "--annotation-size"};
constexpr std::array<std::string_view, 1> kOfQuadtree = {"--quadtree-epsilon"};

struct Need {
  std::span<const std::string_view> flags;
  bool (*met)(const RenderJob&);
  std::string_view text;  // behind "applies to"
};

// The first unmet need of a flag is reported.
constexpr Need kNeeds[] = {
    {kOfExr, writesExr, "EXR pictures (none is written)"},
    {kOfPng, writesPng, "PNG pictures (none is written)"},
    {kOfJpeg, writesJpeg, "JPEG pictures (none is written)"},
    {kOfOpacity, composites, "--mode composite (found a projection)"},
    {kOfLight, hasLight, "--shading phong (found none)"},
    {kOfAttenuation, attenuates, "--mode attenuated-mip (found another mode)"},
    {kOfLens, hasLens, "depth of field (found no --aperture)"},
    {kOfLegend, hasLegend, "a legend (found no --legend)"},
    {kOfAnnotations, hasAnnotations, "annotations (none is drawn)"},
    {kOfQuadtree, approximates, "--visibility quadtree (found another method)"},
};

}  // namespace

std::vector<std::string> idleFlags(const GivenFlags& flags, const RenderJob& job) {
  std::vector<std::string> out, seen;
  for (const Need& need : kNeeds) {
    if (need.met(job)) continue;
    for (const std::string_view flag : need.flags) {
      if (!flags.has(flag) || std::find(seen.begin(), seen.end(), flag) != seen.end()) continue;
      seen.emplace_back(flag);
      out.push_back(fmt::format("{}: has no effect here; applies to {}", flag, need.text));
    }
  }
  return out;
}

}  // namespace kiln
