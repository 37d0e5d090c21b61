#include "sequence/frame_annotations.h"

#include <fmt/format.h>

#include "annotate/font.h"
#include "annotate/legend.h"
#include "annotate/scale_bar.h"
#include "frame/background.h"
#include "job/job_facts.h"

namespace kiln {

void requireFont(const RenderJob& job) {
  if (job.picture.annotations.letters()) font();
}

namespace {

// The facts that need no camera.
AnnotatedPicture pictureOf(const FrameScene& scene) {
  AnnotatedPicture out;
  out.annotations = scene.picture.annotations;
  out.box = scene.box;
  out.shown = scene.shown;
  out.projected = !engineOf(scene.picture).capabilities().composites;
  out.clipping = scene.picture.clipping;
  return out;
}

AnnotatedPicture pictureSeenBy(const FrameScene& scene, const View& view) {
  AnnotatedPicture out = pictureOf(scene);
  out.view = view;
  out.target_depth = (view.view_from_world * glm::dvec4(scene.camera.target, 1)).z;
  return out;
}

// A video alone has no transparency: players show black.
Background backgroundBehind(const RenderJob& job, const FrameScene& scene) {
  const Background out = backgroundOf(scene.picture, scene.transfer_function);
  const OutputOptions& output = job.output;
  const bool video_alone = !output.video.path.empty() && output.path.empty() && output.files.empty();
  return video_alone ? overPaper(out, glm::dvec3(0)) : out;
}

}  // namespace

void warnOfLostAnnotations(const FrameScene& scene, Progress& progress) {
  if (!scene.picture.annotations.scale_bar) return;
  const AnnotatedPicture picture = pictureSeenBy(scene, resolve(scene.camera, scene.picture.size));
  const auto width = widthBelowScaleBar(picture);
  if (!width) return;
  const ScaleBar bar = scaleBarOf(picture);
  const bool given = scene.picture.annotations.scale_bar_length.has_value();
  progress.warn(
      fmt::format("{}: the bar must fit between the margins of the picture, which are {:.3g} {} apart at its "
                  "target (found {}); no bar is drawn; give a {}",
                  given ? "--scale-bar-length" : "--scale-bar", *width, bar.unit, bar.label,
                  given ? "shorter length" : "larger --size"));
}

std::vector<FreeEdges> freeEdges(const FrameScene& scene) {
  AnnotatedPicture picture = pictureOf(scene);
  picture.view.size = scene.picture.size;
  return legendEdges(picture);
}

Annotators annotatorsOf(const RenderJob& job, const DrawnFrame& drawn) {
  const FrameScene& scene = drawn.scene;
  Annotators out(drawn.views.size());
  if (!scene.picture.annotations.any()) return out;
  for (std::size_t i = 0; i < out.size(); ++i) {
    AnnotatedPicture picture = pictureSeenBy(scene, drawn.views[i].view);
    picture.pixels = drawnPixels(scene.picture.size, scene.picture.crop);
    picture.background = backgroundBehind(job, scene);
    picture.has_depth = hidesOutline(job);
    out[i] = std::make_unique<Annotator>(picture);
  }
  return out;
}

}  // namespace kiln
