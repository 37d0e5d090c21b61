#include "job/job_animation.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "base/error.h"
#include "job/frame_list.h"
#include "job/job_names.h"
#include "job/job_parts.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

bool frameNumber(double v) { return v >= 0 && v <= kLastFrame; }

// The keys of "keyframes", each with its value read by `valueOf(object)`.
template <class T, class ValueOf>
std::vector<Key<T>> keysFrom(const JobObject& owner, Ease ease, const ValueOf& value_of) {
  constexpr std::string_view kExpected = "a list of at least one key [{frame, …}, …]";
  const auto objects = owner.objects("keyframes", kExpected, {kMostKeys, "keys"});
  if (!objects || objects->empty()) owner.refuse("keyframes", kExpected);
  std::vector<Key<T>> out;
  for (const JobObject& object : *objects) {
    Key<T> key;
    key.value = value_of(object);
    const auto frame = object.number("frame", fmt::format("a frame's number from 0 to {}", kLastFrame), frameNumber);
    if (!frame) object.complain("frame", "is missing; a key has the number of its frame");
    key.frame = *frame;
    if (!out.empty() && !(out.back().frame < key.frame)) object.refuse("frame", "a frame after that of the key before");
    key.ease = static_cast<Ease>(object.choice("ease", kEaseNames).value_or(static_cast<std::size_t>(ease)));
    out.push_back(std::move(key));
  }
  return out;
}

// Reads the keyframes of an object without other keys.
template <class T, class ValueOf>
std::vector<Key<T>> onlyKeysFrom(const JobObject& owner, JobKeys owner_keys, JobKeys key_keys,
                                 const ValueOf& value_of) {
  owner.requireKnown(owner_keys);
  return keysFrom<T>(owner, Ease::kLinear, [&](const JobObject& key) {
    key.requireKnown(key_keys);
    return value_of(key);
  });
}

Turntable turntableFrom(const JobObject& object) {
  object.requireKnown(job_keys::kTurntable);
  Turntable out;
  const auto frames = object.integer("frames", 1, static_cast<std::int64_t>(kMostFrames));
  if (!frames) object.complain("frames", "is missing; a turntable has the number of its frames");
  out.frames = static_cast<int>(*frames);
  out.degrees = object
                    .number("degrees", "a number of degrees from -36000 to 36000",
                            [](double v) { return v >= -36000 && v <= 36000; })
                    .value_or(out.degrees);
  out.axis = worldVectorFrom(object, "axis");
  if (out.axis && !(glm::length(*out.axis) > 0)) object.refuse("axis", "a direction, which the zero vector is not");
  return out;
}

CameraKeyframes keyframesFrom(const JobObject& camera) {
  CameraKeyframes out;
  out.keys = keysFrom<CameraSpec>(camera, Ease::kSmooth,
                                  [](const JobObject& key) { return cameraFrom(key, job_keys::kCameraKey); });
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

// Complains of the second of two neighbours that nothing lies between.
template <class T, class Matches>
void requireAlike(const JobObject& owner, const std::vector<Key<std::vector<T>>>& keys, const char* things,
                  const Matches& matches) {
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const auto &before = keys[k - 1].value, &here = keys[k].value;
    bool alike = before.size() == here.size();
    for (std::size_t i = 0; alike && i < here.size(); ++i) alike = matches(before[i], here[i]);
    if (alike) continue;
    owner.complain("keyframes",
                   fmt::format("expected as many {} in each key, each of the same kind as in the key before and not in "
                               "the opposite direction; that at frame {} differs",
                               things, keys[k].frame));
  }
}

// Reads the distance of the eyes and their convergence.
Stereo eyesFrom(const JobObject& object) {
  constexpr std::string_view kExpected = "a number of world units above 0";
  Stereo out;
  const auto interocular = object.number("interocular", kExpected, legal::positiveLength);
  if (!interocular) object.complain("interocular", "is missing; it is the distance between both eyes");
  out.interocular = *interocular;
  out.convergence = object.number("convergence", kExpected, legal::positiveLength);
  return out;
}

std::vector<Key<Stereo>> eyeKeysFrom(const JobObject& stereo) {
  for (const std::string_view key : {"interocular", "convergence"}) {
    if (stereo.has(key)) stereo.complain(key, "is each keyframe's where there are keyframes");
  }
  auto out = keysFrom<Stereo>(stereo, Ease::kLinear, [](const JobObject& key) {
    key.requireKnown(job_keys::kStereoKey);
    return eyesFrom(key);
  });
  for (const Key<Stereo>& key : out) {
    if (key.value.convergence.has_value() == out.front().value.convergence.has_value()) continue;
    stereo.complain("keyframes", fmt::format("expected a convergence in all keys or in none; that at frame {} differs "
                                             "from the first",
                                             key.frame));
  }
  return out;
}

}  // namespace

void readStereo(const JobObject& root, RenderJob& job) {
  const auto stereo = root.object("stereo");
  if (!stereo) return;
  stereo->requireKnown(job_keys::kStereo);
  const auto eye = stereo->choice("eye", kStereoEyeNames);
  if (!eye) stereo->complain("eye", "is missing; a picture shows what the left eye sees, the right eye, or both");
  if (stereo->has("keyframes")) job.animation.stereo = eyeKeysFrom(*stereo);
  job.picture.stereo = job.animation.stereo.empty() ? eyesFrom(*stereo) : job.animation.stereo.front().value;
  job.picture.stereo->eye = static_cast<StereoEye>(*eye);
}

void readCamera(const JobObject& root, RenderJob& job) {
  const auto camera = root.object("camera");
  if (!camera) return;
  job.picture.camera = cameraFrom(*camera, job_keys::kCameraPath);
  std::vector<std::string_view> paths;
  for (const std::string_view path : {"turntable", "keyframes", "matrices"}) {
    if (camera->has(path)) paths.push_back(path);
  }
  if (paths.size() > 1) camera->complain(paths[1], fmt::format("contradicts {}; a camera has one of them", paths[0]));
  if (camera->has("pivot") && !camera->has("keyframes"))
    camera->complain("pivot", "is of keyframes, which are missing");
  if (camera->has("turntable")) job.animation.camera = turntableFrom(*camera->object("turntable"));
  if (camera->has("keyframes")) job.animation.camera = keyframesFrom(*camera);
  if (camera->has("matrices")) job.animation.camera = matricesFrom(*camera);
}

void readTransferFunction(const JobObject& owner, TransferFunctionChoice& still,
                          std::vector<Key<TransferFunctionChoice>>& keys) {
  if (!owner.isObject("transferFunction") || !owner.object("transferFunction")->has("keyframes")) {
    if (auto choice = transferFunctionChoiceFrom(owner)) still = std::move(*choice);
    return;
  }
  const auto function = [](const JobObject& key) {
    const auto choice = transferFunctionChoiceFrom(key, "function");
    if (!choice) key.complain("function", "is missing; a key has a preset, a file or a function");
    return *choice;
  };
  keys = onlyKeysFrom<TransferFunctionChoice>(*owner.object("transferFunction"), job_keys::kFunctionKeys,
                                              job_keys::kFunctionKey, function);
}

void readLights(const JobObject& root, RenderJob& job) {
  if (!root.has("lights")) return;
  if (!root.isObject("lights")) {
    job.picture.shading.lights = lightsFrom(root);
    return;
  }
  const JobObject owner = *root.object("lights");
  const auto lights = [](const JobObject& key) {
    if (!key.has("lights")) key.complain("lights", "is missing; a key has a list of lights");
    return lightsFrom(key);
  };
  job.animation.lights = onlyKeysFrom<std::vector<Light>>(owner, job_keys::kLightsKeys, job_keys::kLightsKey, lights);
  requireAlike(owner, job.animation.lights, "lights", [](const Light& a, const Light& b) {
    return a.kind == b.kind && (a.kind != LightKind::kDirectional || mayMix(a.place, b.place));
  });
}

void readClipping(const JobObject& root, RenderJob& job) {
  if (!root.isObject("clip")) {
    job.picture.clipping = clippingFrom(root);
    return;
  }
  job.picture.clipping = regionsFrom(root);
  const JobObject owner = *root.object("clip");
  const auto planes = [](const JobObject& key) {
    if (!key.has("planes")) key.complain("planes", "is missing; a key has a list of planes");
    return planesFrom(key, "planes");
  };
  job.animation.clip = onlyKeysFrom<std::vector<ClipPlane>>(owner, job_keys::kClipKeys, job_keys::kClipKey, planes);
  requireAlike(owner, job.animation.clip, "planes",
               [](const ClipPlane& a, const ClipPlane& b) { return mayMix(a.normal, b.normal); });
}

void readFrames(const JobObject& root, RenderJob& job) {
  const auto text = root.text("frames", "frames such as \"1-100\", \"1-100x2\" or \"1-10,20\"");
  if (!text) return;
  try {
    job.frames = parseFrames(*text);
  } catch (const Error& error) {
    root.complain("frames", error.what());
  }
}

}  // namespace kiln
