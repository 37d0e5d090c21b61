// What a job shows at a frame, every choice made for a volume.
#pragma once

#include "scene/render_job.h"
#include "store/manifest.h"

namespace kiln {

struct FrameScene {
  PictureOptions picture;  // its camera and transfer function are the still picture's: those below are drawn
  Camera camera;
  TransferFunction transfer_function;
};

/// The function that `choice` is in the picture: as `resolve`, but where the picture projects values, "auto" is their
/// grey.
TransferFunction resolvedFor(const PictureOptions& picture, const TransferFunctionChoice& choice,
                             const Manifest& manifest);

/// The job's scenes over one volume. Files are read once.
class SceneOfJob {
 public:
  /// requires: both outlive this. throws: Error where a transfer function cannot be read or used.
  SceneOfJob(const RenderJob& job, const Manifest& manifest);
  /// throws: Error kUsage where the camera cannot be used.
  FrameScene at(int frame) const;

 private:
  const RenderJob& job_;
  const Manifest& manifest_;
  std::vector<TransferFunction> functions_;  // of each key, or the still one
};

}  // namespace kiln
