#include "scene/frame_scene.h"

#include <utility>

#include "scene/presets.h"
#include "scene/transfer_function_fade.h"

namespace kiln {

TransferFunction resolvedFor(const PictureOptions& picture, const TransferFunctionChoice& choice,
                             const Manifest& manifest) {
  const auto* const name = std::get_if<std::string>(&choice);
  if (picture.mode == Mode::kComposite || name == nullptr || *name != "auto")
    return resolve(choice, picture.window, manifest);
  return resolve(displayGrey(manifest), picture.window, manifest);
}

SceneOfJob::SceneOfJob(const RenderJob& job, const Manifest& manifest) : job_(job), manifest_(manifest) {
  const PictureOptions& still = job.picture;
  for (const auto& key : job.animation.functions) functions_.push_back(resolvedFor(still, key.value, manifest));
  if (functions_.empty()) functions_.push_back(resolvedFor(still, still.transfer_function, manifest));
}

FrameScene SceneOfJob::at(int frame) const {
  const Animation& animation = job_.animation;
  FrameScene out{job_.picture, {}, functions_.front()};
  if (const auto part = std::exchange(out.picture.part, std::nullopt))
    out.picture.clipping.part = boxOfPart(*part, manifest_.geometry().dims, manifest_.brick_size);
  out.camera = cameraAt(animation.camera, out.picture.camera, frame, manifest_.geometry(), out.picture.size);
  if (functions_.size() > 1) {
    const auto [i, t] = mixAt(KeyTimes(animation.functions), frame);
    out.transfer_function = faded(functions_[i], functions_[i + 1], t);
  }
  const auto between = [&](const auto& keys) {
    const auto [i, t] = mixAt(KeyTimes(keys), frame);
    return t == 0 ? keys[i].value : mixed(keys[i].value, keys[i + 1].value, t);
  };
  if (!animation.lights.empty()) out.picture.shading.lights = between(animation.lights);
  if (!animation.clip.empty()) {
    const std::vector<ClipPlane> planes = between(animation.clip);
    out.picture.clipping.planes.insert(out.picture.clipping.planes.end(), planes.begin(), planes.end());
  }
  return out;
}

}  // namespace kiln
