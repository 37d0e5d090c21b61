// Reads objects of a job with keys that depend on each other.
#include <algorithm>

#include "base/error.h"
#include "base/nearest_word.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "job/job_parts.h"
#include "job/transfer_function_choice.h"
#include "job/transfer_function_json.h"
#include "scene/transfer/presets.h"
#include "scene/volume_part.h"

namespace kiln {

CameraSpec cameraFrom(const JobObject& object) {
  CameraSpec spec;
  readOptions(cameraOptions(), object, spec);
  return spec;
}

Shading shadingFrom(const JobObject& object) {
  Shading shading;
  readOptions(shadingOptions(), object, shading);
  return shading;
}

// The kind of a light decides about its place.
Light lightFrom(const JobObject& object) {
  Light light;
  if (const auto kind = object.choice("type", kLightNames)) light.kind = static_cast<LightKind>(*kind);
  Options<Light> options = lightOptions();
  std::erase_if(options, [&](const Option<Light>& option) {
    return (option.key == "direction" && !isFar(light.kind)) ||
           (option.key == "position" && light.kind != LightKind::kPoint);
  });
  for (Option<Light>& option : options) {
    if (option.key == "direction") option.missing = "a light far away has one";
    if (option.key == "position") option.missing = "a point light has one";
  }
  readOptions(options, object, light);
  return light;
}

// A name without a dot or a slash that is no preset is a misspelt preset, not a file.
std::optional<TransferFunctionChoice> transferFunctionChoiceFrom(const JobObject& owner, std::string_view key) {
  if (!owner.has(key)) return std::nullopt;
  if (!owner.isText(key)) return transferFunctionFrom(*owner.object(key));
  const std::string name = *owner.text(key, "a preset, points, a file or an object");
  try {
    if (auto written = writtenChoice(name)) return written;
  } catch (const Error& error) {
    owner.complain(key, error.what());
  }
  if (name.find_first_of("./") != std::string::npos) return owner.path().parent_path() / name;
  const std::vector<std::string_view> words(presetNames().begin(), presetNames().end());
  owner.complain(key, "'" + name + "' is neither a preset nor a file name with an ending; did you mean '" +
                          std::string(nearestWord(name, words)) + "'?");
}

void replaceClipPlanes(const JobObject& owner, Clipping& clipping) {
  std::vector<ClipPlane> planes;
  clipPlaneList().read(owner, "clip", planes);
  clipping.planes.resize(clipping.box_faces);
  clipping.planes.insert(clipping.planes.end(), planes.begin(), planes.end());
}

void readPart(const JobObject& root, PictureOptions& picture) {
  picture.part.reset();
  picture.clipping.part.reset();
  if (!root.isText("part")) return VoxelBounds{}.read(root, "part", picture.clipping.part);
  picture.part = partNumbered(*root.text("part", "a part"));
  if (!picture.part) root.refuse("part", "\"I/N\", I from 1 to N, or a box of voxels [x0, y0, z0, x1, y1, z1]");
}

// Options of a job with one volume; with several volumes, each volume has its own.
void readVolumes(const JobObject& root, RenderJob& job) {
  for (const char* key : {"volume", "transferFunction", "window", "region", "mask", "colorBy", "section"}) {
    if (root.has(key)) root.complain(key, "is each volume's own where there are several; put it into \"volumes\"");
  }
  volumeList().read(root, "volumes", job.volumes);
  job.volume = job.volumes.front().volume;
}

}  // namespace kiln
