#include "job/stated_job.h"

#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "job/job_names.h"
#include "job/job_options.h"

namespace kiln {
namespace {

using nlohmann::ordered_json;

// The options whose values differ from those of `plain`.
template <class Owner>
ordered_json differences(const Options<Owner>& options, const Owner& owner, const Owner& plain) {
  ordered_json out = ordered_json::object();
  for (const Option<Owner>& option : options) {
    if (option.key.empty()) continue;
    ordered_json value;
    if (!option.value.inside.empty()) {
      value = differences(option.value.inside, owner, plain);
      if (value.empty()) continue;
    } else if (option.value.write) {
      value = option.value.write(owner);
      if (value == option.value.write(plain)) continue;
    }
    if (!value.is_null()) out[std::string(option.key)] = std::move(value);
  }
  return out;
}

template <class T>
ordered_json keyframes(const Options<Key<T>>& options, const std::vector<Key<T>>& keys) {
  ordered_json out = ordered_json::array();
  for (const Key<T>& key : keys) {
    ordered_json item = {{"frame", key.frame}, {"ease", nameIn(kEaseNames, key.ease)}};
    if constexpr (std::is_same_v<T, TransferFunctionChoice>)
      item["function"] = statedJson(key.value);
    else
      item.update(differences(options, key, Key<T>{key.frame, key.ease, {}}));
    out.push_back(std::move(item));
  }
  return out;
}

// Lists of a key are written even if they are empty.
template <class T>
ordered_json listKeyframes(const Options<Key<std::vector<T>>>& options, const std::vector<Key<std::vector<T>>>& keys,
                           const char* name) {
  ordered_json out = keyframes(options, keys);
  for (ordered_json& item : out) {
    if (!item.contains(name)) item[name] = ordered_json::array();
  }
  return {{"keyframes", std::move(out)}};
}

ordered_json matricesJson(const CameraMatrices& matrices) {
  ordered_json out = ordered_json::array();
  for (const glm::dmat4& matrix : matrices) {
    ordered_json rows = ordered_json::array();
    for (int row = 0; row < 4; ++row) rows.push_back({matrix[0][row], matrix[1][row], matrix[2][row], matrix[3][row]});
    out.push_back(std::move(rows));
  }
  return out;
}

void putCameraPath(const CameraPath& path, ordered_json& out) {
  if (const auto* const turntable = std::get_if<Turntable>(&path)) {
    ordered_json object = differences(turntableOptions(), *turntable, Turntable());
    object["frames"] = turntable->frames;
    out["camera"]["turntable"] = std::move(object);
  } else if (const auto* const keys = std::get_if<CameraKeyframes>(&path)) {
    out["camera"]["keyframes"] = keyframes(cameraKeyOptions(), keys->keys);
    if (keys->pivot) out["camera"]["pivot"] = nameIn(kPivotNames, *keys->pivot);
  } else if (const auto* const matrices = std::get_if<CameraMatrices>(&path)) {
    out["camera"]["matrices"] = matricesJson(*matrices);
  }
}

// Faces of a box of the world have a key, and other planes have a second key.
void putPlanes(const Clipping& clipping, ordered_json& out) {
  out.erase("clip");
  constexpr std::size_t kFaces = 6;
  std::vector<ClipPlane> planes = clipping.planes;
  if (clipping.box_faces == kFaces) {
    out["worldRegion"] = {-planes[0].offset, -planes[2].offset, -planes[4].offset,
                          planes[1].offset,  planes[3].offset,  planes[5].offset};
    planes.erase(planes.begin(), planes.begin() + kFaces);
  }
  if (!planes.empty()) out["clip"] = clipPlaneList().write(planes);
}

void putFunction(const TransferFunctionChoice& still, const std::vector<Key<TransferFunctionChoice>>& keys,
                 ordered_json& out) {
  if (!keys.empty())
    out["transferFunction"] = {{"keyframes", keyframes(functionKeyOptions(), keys)}};
  else if (const auto* const name = std::get_if<std::string>(&still); name == nullptr || *name != "auto")
    out["transferFunction"] = statedJson(still);
}

ordered_json volumeJson(const VolumeOptions& given) {
  VolumeOptions volume = given;
  volume.volume.clear();
  volume.transfer_function = std::string("auto");
  ordered_json out = differences(volumeOptions(), volume, VolumeOptions());
  putFunction(given.transfer_function, given.functions, out);
  putPlanes(given.clipping, out);
  return out;
}

}  // namespace

ordered_json statedJson(const TransferFunctionChoice& choice) {
  if (const auto* const name = std::get_if<std::string>(&choice)) return *name;
  if (const auto* const file = std::get_if<std::filesystem::path>(&choice)) return file->generic_string();
  return resolvedJson(transferFunctionOptions(), std::get<TransferFunction>(choice));
}

ordered_json statedJson(const RenderJob& given) {
  RenderJob job = given;
  job.volume.clear();
  job.volumes.clear();
  job.output = {};
  job.trace.clear();
  job.picture.transfer_function = std::string("auto");
  if (!job.animation.stereo.empty()) {
    job.picture.stereo->interocular = Stereo().interocular;
    job.picture.stereo->convergence.reset();
  }
  ordered_json out = {{"kiln", kJobFormat}};
  out.update(differences(jobOptions(), job, RenderJob()));
  putCameraPath(given.animation.camera, out);
  if (given.volumes.empty()) putFunction(given.picture.transfer_function, given.animation.functions, out);
  putPlanes(given.picture.clipping, out);
  const Animation& animation = given.animation;
  if (!animation.lights.empty()) out["lights"] = listKeyframes(lightsKeyOptions(), animation.lights, "lights");
  if (!animation.clip.empty()) out["clip"] = listKeyframes(clipKeyOptions(), animation.clip, "planes");
  if (!animation.stereo.empty()) {
    out["stereo"].erase("interocular");
    out["stereo"]["keyframes"] = keyframes(stereoKeyOptions(), animation.stereo);
  }
  for (const VolumeOptions& volume : given.volumes) out["volumes"].push_back(volumeJson(volume));
  return out;
}

}  // namespace kiln
