// The scene of a job at one frame, with every choice for its volumes made.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "job/render_job.h"
#include "scene/camera/framing.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// A volume of a scene with several volumes.
struct VolumeScene {
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;       // includes the clipping of all volumes
  double world_per_own;    // lengths of the picture's world per length of the volume's own world, the function's unit
  Hash128 index_checksum;  // identifies the content of the volume
};

/// The function that colours a volume, for a legend.
struct ShownFunction {
  std::string name;  // name of the file that the function's values are from
  TransferFunction function;
  ValueRange values;                               // range of the file's values
  std::optional<std::vector<double>> labels = {};  // labels with voxels, if they are known
  bool colors_only = false;                        // its opacities count for nothing (--color-by)
};

ShownFunction shownFunction(const std::filesystem::path& file, const TransferFunction& function,
                            const Manifest& manifest);

struct FrameScene {
  /// Samples and background are resolved. Camera and transfer function of the picture are the still picture's; the
  /// frame uses the members below.
  PictureOptions picture;
  Camera camera;
  TransferFunction transfer_function;
  std::vector<Hash128> companions;   // index checksums of masks and volumes of colours
  std::vector<VolumeScene> volumes;  // empty for a single volume; the first volume's function is also above
  VolumeGeometry box;                // the box around all volumes, in the axes of the first
  std::vector<ShownFunction> shown;  // with a legend: of each volume, or of the volume that colours it
  bool masked = false;               // a mask hides voxels of a volume
  /// Functions of volumes that other volumes colour, as SceneInputs::colors.
  std::vector<std::optional<ShownFunction>> colors = {};
};

/// Returns the function for `choice` in the picture, as `resolve`; where values are projected, "auto" is a ramp of
/// grey, or of `color`, and presets without a window cover projectionRange.
TransferFunction resolvedFor(const PictureOptions& picture, const TransferFunctionChoice& choice,
                             const Manifest& manifest, const std::optional<glm::dvec3>& color = {});

/// Returns the box and the outline, in the picture's world, of what the functions of one of the volumes show inside its
/// clipping; a box without voxels if that is nothing.
using ShownBoxOf = std::function<FramedBox(std::size_t volume, const std::vector<TransferFunction>& functions,
                                           const Clipping& clipping)>;

/// Returns choices of edges of the picture that a camera leaves free for a legend (FramedBox), by the picture and the
/// functions of the legend. The scene has no camera yet, and no text in place of placeholders.
using FreeEdgesOf = std::function<std::vector<FreeEdges>(const FrameScene& scene)>;

/// Inputs of scenes, from the open volumes of a job and from the annotations of its pictures.
struct SceneInputs {
  ShownBoxOf shown_box = {};                              // without it, Fit::kVisible is Fit::kRegion
  FreeEdgesOf free_edges = {};                            // without it, a legend lies over the picture
  std::vector<Hash128> companions = {};                   // for FrameScene::companions
  std::vector<std::optional<ShownFunction>> colors = {};  // one for each volume; nothing for colours of its own
};

/// The job's scenes over one volume. Files are read once.
class SceneOfJob {
 public:
  /// requires: both outlive the object. throws: Error for an unreadable or unusable transfer function.
  SceneOfJob(const RenderJob& job, const Manifest& manifest) : SceneOfJob(job, std::vector{&manifest}) {}
  /// Takes the manifests of all volumes; a framing fits the box around all. In a time series (RenderJob::series),
  /// framing and transfer functions are those of all frames, and a framing fits whole volumes.
  SceneOfJob(const RenderJob& job, std::vector<const Manifest*> manifests, const SceneInputs& inputs = {},
             const Progress& progress = Progress());
  /// throws: Error kUsage where the camera cannot be used.
  FrameScene at(int frame) const;
  /// Returns the largest number of samples of all frames; frames whose camera cannot be used are left out.
  int mostSamples(const Progress& progress = Progress()) const;
  /// Returns a volume's still function, or the functions of its keys.
  const std::vector<TransferFunction>& functionsOf(std::size_t volume) const { return functions_[volume].values; }
  /// Returns the memory of all functions, their copies, and their text in a picture's header. unit: bytes.
  std::uint64_t functionBytes() const;

 private:
  // The functions of one volume.
  struct Functions {
    const std::vector<Key<TransferFunctionChoice>>* keys;
    std::vector<TransferFunction> values;  // one per key, or the still function
    TransferFunction at(int frame) const;
  };
  const Manifest& manifest() const { return *manifests_.front(); }
  Clipping clippingOf(std::size_t volume) const;
  Fit fit() const;
  std::vector<TransferFunction> fittedFunctions(std::size_t volume) const;
  FramedBox framedBox(const ShownBoxOf& shown_box) const;
  std::vector<FreeEdges> freeEdges(const FreeEdgesOf& free_edges) const;
  std::vector<ShownFunction> shownIn(const FrameScene& scene, const std::vector<const Manifest*>& manifests) const;
  FrameScene unframed(int frame) const;
  Camera cameraOf(int frame) const;
  // throws: Error kUsage, with a usual distance, for a pair of eyes without a distance.
  void requireInterocular() const;
  int samplesOf(const Camera& camera) const;

  const RenderJob& job_;
  const std::vector<const Manifest*> manifests_;
  std::vector<const Manifest*> looks_;  // the manifests that decide framing and colours: a volume's own, or its series'
  const VolumeGeometry geometry_;       // geometry of the box around all of them
  std::vector<Functions> functions_;    // one for each volume
  const std::vector<Hash128> companions_;
  const std::vector<std::optional<ShownFunction>> colors_;  // functions of volumes that other volumes colour
  FramedBox framed_;                                        // what cameras fit
};

}  // namespace kiln
