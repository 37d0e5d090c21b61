#include "sequence/frame_annotations.h"

#include "annotate/font.h"
#include "job/job_facts.h"

namespace kiln {

void requireFont(const RenderJob& job) {
  if (job.picture.annotations.letters()) font();
}

Annotators annotatorsOf(const RenderJob& job, const DrawnFrame& drawn) {
  const FrameScene& scene = drawn.scene;
  Annotators out(drawn.views.size());
  if (!scene.picture.annotations.any()) return out;
  AnnotatedPicture picture;
  picture.annotations = scene.picture.annotations;
  picture.pixels = drawnPixels(scene.picture.size, scene.picture.crop);
  picture.background = backgroundOf(scene.picture, scene.transfer_function);
  picture.shown = scene.shown;
  picture.projected = !engineOf(scene.picture).capabilities().composites;
  picture.has_depth = hidesOutline(job);
  picture.box = scene.box;
  picture.clipping = scene.picture.clipping;
  for (std::size_t i = 0; i < out.size(); ++i) {
    picture.view = drawn.views[i].view;
    picture.target_depth = (picture.view.view_from_world * glm::dvec4(scene.camera.target, 1)).z;
    out[i] = std::make_unique<Annotator>(picture);
  }
  return out;
}

}  // namespace kiln
