// What a job shows at a frame, every choice made for a volume.
#pragma once

#include <vector>

#include "job/render_job.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// One of several volumes of a scene.
struct VolumeScene {
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;       // with what cuts all of them
  double world_per_own;    // lengths of the picture's world per length of the volume's own, which the function is in
  Hash128 index_checksum;  // what the volume holds
};

struct FrameScene {
  /// Its samples are a number. Its camera and transfer function are the still picture's: those below are drawn.
  PictureOptions picture;
  Camera camera;
  TransferFunction transfer_function;
  std::vector<VolumeScene> volumes;  // where there are several; the first's function is also above
};

/// The function that `choice` is in the picture: as `resolve`, but where the picture projects values, "auto" is their
/// grey.
TransferFunction resolvedFor(const PictureOptions& picture, const TransferFunctionChoice& choice,
                             const Manifest& manifest);

/// The job's scenes over one volume. Files are read once.
class SceneOfJob {
 public:
  /// requires: both outlive this. throws: Error where a transfer function cannot be read or used.
  SceneOfJob(const RenderJob& job, const Manifest& manifest) : SceneOfJob(job, std::vector{&manifest}) {}
  /// Of several volumes, `manifests` are theirs, and a framing is of the box around all. Of a time series
  /// (RenderJob::series), framing and transfer functions are those of all its frames.
  SceneOfJob(const RenderJob& job, std::vector<const Manifest*> manifests);
  /// throws: Error kUsage where the camera cannot be used.
  FrameScene at(int frame) const;
  /// That a pixel of any frame takes; a frame whose camera cannot be used has none.
  int mostSamples() const;
  /// Of a volume: the still one, or those of its keys.
  const std::vector<TransferFunction>& functionsOf(std::size_t volume) const { return functions_[volume].values; }

 private:
  // Of a volume.
  struct Functions {
    const std::vector<Key<TransferFunctionChoice>>* keys;
    std::vector<TransferFunction> values;  // of each key, or the still one
    TransferFunction at(int frame) const;
  };
  const Manifest& manifest() const { return *manifests_.front(); }
  Camera cameraOf(int frame) const;
  int samplesOf(const Camera& camera) const;

  const RenderJob& job_;
  const std::vector<const Manifest*> manifests_;
  std::vector<const Manifest*> looks_;  // what each volume is framed and coloured as: itself, or its series
  const VolumeGeometry geometry_;       // of the box around all of those
  std::vector<Functions> functions_;    // of each volume
};

}  // namespace kiln
