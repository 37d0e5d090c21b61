#include "job/job_animation.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "base/error.h"
#include "job/animation.h"
#include "job/frame_list.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "job/job_parts.h"
#include "scene/camera/camera_path.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

// Reads "keyframes". `ease` is the default of a key.
template <class T>
std::vector<Key<T>> keysFrom(const JobObject& owner, const Options<Key<T>>& options, Ease ease) {
  constexpr std::string_view kExpected = "a list of at least one key [{frame, …}, …]";
  const auto objects = owner.objects("keyframes", kExpected, {kMostKeys, "keys"});
  if (!objects || objects->empty()) owner.refuse("keyframes", kExpected);
  std::vector<Key<T>> out;
  for (const JobObject& object : *objects) {
    Key<T> key;
    key.ease = ease;
    readOptions(options, object, key);
    if (!out.empty() && !(out.back().frame < key.frame)) object.refuse("frame", "a frame after that of the key before");
    out.push_back(std::move(key));
  }
  return out;
}

// Reads the keyframes of an object without other keys.
template <class T>
std::vector<Key<T>> onlyKeysFrom(const JobObject& owner, const Options<Key<T>>& options) {
  owner.requireKnown({"keyframes"});
  return keysFrom(owner, options, Ease::kLinear);
}

// Refuses the second of two neighbouring keys without a transition between their values.
template <class T, class Matches>
void requireAlike(const JobObject& owner, const std::vector<Key<std::vector<T>>>& keys, const char* rule,
                  const Matches& matches) {
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const auto &before = keys[k - 1].value, &here = keys[k].value;
    bool alike = before.size() == here.size();
    for (std::size_t i = 0; alike && i < here.size(); ++i) alike = matches(before[i], here[i]);
    if (alike) continue;
    owner.complain("keyframes", fmt::format("expected each key to have as many {} turned to the opposite direction "
                                            "(found another at frame {}); make the key like the key before",
                                            rule, keys[k].frame));
  }
}

std::vector<Key<Stereo>> eyeKeysFrom(const JobObject& stereo) {
  for (const std::string_view key : {"interocular", "convergence"}) {
    if (stereo.has(key)) stereo.complain(key, "is each keyframe's where there are keyframes");
  }
  std::vector<Key<Stereo>> out = keysFrom(stereo, stereoKeyOptions(), Ease::kLinear);
  for (const Key<Stereo>& key : out) {
    if (key.value.convergence.has_value() == out.front().value.convergence.has_value()) continue;
    stereo.complain("keyframes", fmt::format("expected a convergence in all keys or in none; that at frame {} differs "
                                             "from the first",
                                             key.frame));
  }
  return out;
}

}  // namespace

Turntable turntableFrom(const JobObject& object) {
  Turntable out;
  readOptions(turntableOptions(), object, out);
  return out;
}

CameraKeyframes cameraKeyframesFrom(const JobObject& camera) {
  CameraKeyframes out;
  out.keys = keysFrom(camera, cameraKeyOptions(), Ease::kSmooth);
  if (const auto place = camera.choice("pivot", kPivotNames)) out.pivot = static_cast<Pivot>(*place);
  return out;
}

CameraMatrices matricesFrom(const JobObject& camera) {
  constexpr std::string_view kExpected =
      "a list of matrices, each 4 rows of 4 numbers, camera to world: a turn and a move, the last row 0 0 0 1";
  CameraMatrices out;
  const auto matrices = camera.matrices("matrices", kExpected, {kMostMatrices, "matrices"}, legal::length);
  for (const auto& numbers : *matrices) {
    glm::dmat4 matrix;
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column)
        matrix[column][row] = numbers[static_cast<std::size_t>(4 * row + column)];
    }
    if (!isRigid(matrix)) {
      camera.complain("matrices", fmt::format("expected {}; matrix {} of the list is none", kExpected, out.size() + 1));
    }
    out.push_back(matrix);
  }
  if (out.empty()) camera.refuse("matrices", kExpected);
  return out;
}

void readStereo(const JobObject& stereo, RenderJob& job) {
  std::vector<std::string_view> keys = keysOf(stereoOptions());
  keys.push_back("keyframes");
  stereo.requireOneOf(keys);
  if (!stereo.has("eye")) stereo.complain("eye", "is missing; " + std::string(stereoOptions().front().missing));
  if (stereo.has("keyframes"))
    job.animation.stereo = eyeKeysFrom(stereo);
  else if (!stereo.has("interocular"))
    stereo.complain("interocular", "is missing; " + std::string(kMissingInterocular));
  job.picture.stereo = job.animation.stereo.empty() ? Stereo() : job.animation.stereo.front().value;
  readKnown(stereoOptions(), stereo, *job.picture.stereo);
}

void readCamera(const JobObject& camera, RenderJob& job) {
  std::vector<std::string_view> paths;
  for (const std::string_view path : {"turntable", "keyframes", "matrices"}) {
    if (camera.has(path)) paths.push_back(path);
  }
  if (paths.size() > 1) camera.complain(paths[1], fmt::format("contradicts {}; a camera has one of them", paths[0]));
  if (camera.has("pivot") && !camera.has("keyframes")) camera.complain("pivot", "is of keyframes, which are missing");
  readOptions(cameraObjectOptions(), camera, job);
}

void readTransferFunction(const JobObject& owner, TransferFunctionChoice& still,
                          std::vector<Key<TransferFunctionChoice>>& keys) {
  if (!owner.isObject("transferFunction") || !owner.object("transferFunction")->has("keyframes")) {
    still = *transferFunctionChoiceFrom(owner);
    keys.clear();
    return;
  }
  keys = onlyKeysFrom(*owner.object("transferFunction"), functionKeyOptions());
}

void readLights(const JobObject& root, RenderJob& job) {
  job.animation.lights.clear();
  if (!root.isObject("lights")) return lightList().read(root, "lights", job.picture.shading.lights);
  const JobObject owner = *root.object("lights");
  job.animation.lights = onlyKeysFrom(owner, lightsKeyOptions());
  requireAlike(owner, job.animation.lights, "lights, of equal types and shadows, none",
               [](const Light& a, const Light& b) {
                 return a.kind == b.kind && a.shadow == b.shadow && (!isFar(a.kind) || mayMix(a.place, b.place));
               });
}

void readClipPlanes(const JobObject& root, RenderJob& job) {
  job.animation.clip.clear();
  if (!root.isObject("clip")) return replaceClipPlanes(root, job.picture.clipping);
  const JobObject owner = *root.object("clip");
  job.animation.clip = onlyKeysFrom(owner, clipKeyOptions());
  requireAlike(owner, job.animation.clip, "planes, none",
               [](const ClipPlane& a, const ClipPlane& b) { return mayMix(a.normal, b.normal); });
}

void readFrames(const JobObject& root, RenderJob& job) {
  const std::string text = *root.text("frames", "frames such as \"1-100\", \"1-100x2\" or \"1-10,20\"");
  try {
    job.frames = parseFrames(text);
  } catch (const Error& error) {
    root.complain("frames", error.what());
  }
}

}  // namespace kiln
