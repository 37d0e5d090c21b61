// The views of a scene and their files: both eyes of a pair, deep images, panoramas.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/file/file.h"
#include "job/job_facts.h"
#include "job/render_job.h"
#include "job/stereo.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void refuse(const fs::path& path, std::string_view option, std::string_view why) {
  throw Error(ErrorCode::kUsage, path, "", fmt::format("{} of a deep image {}", option, why));
}

void requireDeep(const RenderJob& job, const fs::path& path) {
  const PictureOptions& picture = job.picture;
  const std::string& compression = job.output.exr_compression;
  if (extensionOf(path) != ".exr") refuse(path, "the name", "ends in .exr");
  requireCapability(engineOf(job), &EngineCapabilities::deep, path.string() + ": deep images need",
                    "leave --mode and --lattice out");
  if (oversamples(picture)) refuse(path, "--samples", "is 1: draw it larger, and make it smaller when it is flat");
  if (compression == "piz" || compression.starts_with("dwa")) refuse(path, "--compression", "is none, rle or zips");
  if (drawsBothEyes(picture.stereo) && !hasEyePlace(path))
    refuse(path, "--stereo both", "has a file for each eye: put %V, which becomes left and right, into its name");
}

void requireLens(const RenderJob& job) {
  const Lens& lens = job.picture.lens;
  if (lens.aperture == 0 && lens.focus)
    throw Error(ErrorCode::kUsage, "--focus: a lens without an aperture has all depths sharp; add --aperture");
  if (lens.aperture == 0) return;
  if (projectionOf(job) != Projection::kPerspective)
    throw Error(ErrorCode::kUsage, "--aperture: only a perspective camera has a lens; choose perspective");
  if (drawsDeep(job)) throw Error(ErrorCode::kUsage, "--aperture: samples in depth are of one view; leave --deep out");
  if (drawsPart(job.picture))
    throw Error(ErrorCode::kUsage, "--aperture: partial images are of one view; draw the whole picture");
}

void requirePanorama(const RenderJob& job) {
  const PictureOptions& picture = job.picture;
  if (projectionOf(job) != Projection::kEquirectangular) return;
  const auto refuse_panorama = [](std::string_view option, std::string_view why) {
    throw Error(ErrorCode::kUsage, fmt::format("--projection equirectangular: {} of a panorama {}", option, why));
  };
  if (picture.stereo) refuse_panorama("--stereo", "is not there: a pair of eyes looks one way; choose perspective");
  if (oversamples(picture)) refuse_panorama("--samples", "is 1: its pixels are means of 4 directions as it is");
  if (drawsPart(picture)) refuse_panorama("--part", "is not there; choose perspective or orthographic");
  if (drawsDeep(job)) refuse_panorama("--deep", "is not there: samples in depth are of a picture's plane");
}

}  // namespace

bool lacksInterocular(const RenderJob& job) {
  const std::optional<Stereo>& stereo = job.picture.stereo;
  return stereo && !(stereo->interocular > 0) && job.animation.stereo.empty();
}

bool drawsDeep(const RenderJob& job) {
  const std::vector<OutputFile>& files = job.output.files;
  return (job.output.deep && !job.output.path.empty()) ||
         std::any_of(files.begin(), files.end(), [](const OutputFile& file) { return file.content == Content::kDeep; });
}

const char* viewWithoutTiles(const RenderJob& job) {
  if (drawsDeep(job)) return "a deep image";
  if (drawsBothEyes(job.picture.stereo)) return "both eyes";
  if (drawsPart(job.picture)) return "a partial image";
  if (job.picture.lens.aperture > 0) return "a picture through a lens";
  return projectionOf(job) == Projection::kEquirectangular ? "a panorama" : nullptr;
}

void requireViews(const RenderJob& job) {
  const OutputOptions& output = job.output;
  if (!job.picture.stereo && job.animation.stereo.empty()) {
    for (const fs::path& name : namesOf(output)) {
      if (hasEyePlace(name.filename()))
        throw Error(ErrorCode::kUsage, name, "",
                    "has a place for an eye's name, but no pair is drawn; add --stereo, or leave %V and %v out");
    }
  }
  if (hasEyePlace(output.video.path.filename()))
    throw Error(ErrorCode::kUsage, output.video.path, "",
                "has a place for an eye's name, but a video is one file; leave %V and %v out");
  if (output.deep && !output.video.path.empty()) requireDeep(job, output.video.path);
  if (output.deep && !output.path.empty()) {
    requireDeep(job, output.path);
    if (job.picture.aovs.any() && output.files.empty())
      refuse(output.path, "--aov", "is none: its samples have RGBA, Z and ZBack; name a flat picture in outputs, too");
  }
  for (const OutputFile& file : output.files) {
    if (file.content == Content::kDeep) requireDeep(job, file.path);
  }
  requirePanorama(job);
  requireAnnotations(job);
  requireLens(job);
  if (drawsBothEyes(job.picture.stereo) && drawsPart(job.picture))
    throw Error(ErrorCode::kUsage, "--part: --stereo of a partial image is left or right");
}

bool hidesOutline(const RenderJob& job) {
  return job.picture.annotations.box && engineOf(job).capabilities().depth_and_normal;
}

void requireAnnotations(const RenderJob& job) {
  const Annotations& annotations = job.picture.annotations;
  if (!annotations.legend_title.empty() && !annotations.legend)
    throw Error(ErrorCode::kUsage, "--legend-title: no legend is drawn; add --legend");
  if (!annotations.any()) return;
  if (drawsPart(job.picture))
    throw Error(ErrorCode::kUsage,
                "--part: a partial image is not finished and has no annotations (found some); leave them out");
  if (projectionOf(job) == Projection::kEquirectangular &&
      (annotations.scale_bar || annotations.box || annotations.axes))
    throw Error(ErrorCode::kUsage,
                "--projection equirectangular: a panorama has no scale bar, box or axes; leave --scale-bar, --box and "
                "--axes out, or choose perspective");
  const OutputOptions& output = job.output;
  const bool flat = (!output.path.empty() && !output.deep) || !output.video.path.empty() ||
                    std::any_of(output.files.begin(), output.files.end(),
                                [](const OutputFile& file) { return holdsColors(file.content); });
  if (!flat && !(output.path.empty() && output.files.empty()))
    throw Error(ErrorCode::kUsage,
                "annotations: are drawn over colours of a flat picture (found no such file); add one to outputs, or "
                "leave the annotations out");
}

std::vector<PictureOptions> eyesOf(const PictureOptions& picture) {
  if (!drawsBothEyes(picture.stereo)) return {picture};
  std::vector<PictureOptions> out(2, picture);
  out[0].stereo->eye = StereoEye::kLeft;
  out[1].stereo->eye = StereoEye::kRight;
  return out;
}

std::vector<OutputFile> ofEyes(const std::vector<OutputFile>& files, const std::optional<Stereo>& stereo) {
  std::vector<OutputFile> out;
  for (const OutputFile& file : files) {
    if (!stereo || !hasEyePlace(file.path)) {
      out.push_back(file);
      continue;
    }
    for (const StereoEye eye : {StereoEye::kLeft, StereoEye::kRight}) {
      if (stereo->eye != eye && stereo->eye != StereoEye::kBoth) continue;
      out.push_back({pathOfEye(file.path, eye), file.content, eye});
    }
  }
  return out;
}

}  // namespace kiln
