// Annotations of the views of a drawn frame.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "annotate/annotator.h"
#include "frame/background.h"
#include "sequence/opened_job.h"

namespace kiln {

/// throws: Error kUnsupported if the job has annotations with letters and there is no font.
void requireFont(const RenderJob& job);

/// Warns of annotations that the frame has no room for.
void warnOfLostAnnotations(const FrameScene& scene, Progress& progress);

/// Returns choices of edges of the picture that cameras leave free for its legend. The scene needs no camera.
std::vector<FreeEdges> freeEdges(const FrameScene& scene);

/// One for each view, in order; null without annotations.
using Annotators = std::vector<std::unique_ptr<Annotator>>;
/// Returns the annotations of a frame of the job.
Annotators annotatorsOf(const RenderJob& job, const DrawnFrame& drawn);

/// The rows of a drawn view as a display shows them, with annotations. requires: all arguments outlive the object.
class ShownView {
 public:
  /// `annotator` and `depth` may be null.
  ShownView(const Image& image, const FrameScene& scene, const Annotator* annotator, const float* depth)
      : shown_(shownRows(image, drawnPixels(scene.picture.size, scene.picture.crop).y0,
                         finishOf(scene.picture, scene.transfer_function))) {
    if (annotator != nullptr) annotated_.emplace(*shown_, *annotator, depth);
  }
  ImageRows& rows() { return annotated_ ? static_cast<ImageRows&>(*annotated_) : *shown_; }

 private:
  const std::unique_ptr<ImageRows> shown_;
  std::optional<AnnotatedRows> annotated_;
};

}  // namespace kiln
