// The table of all keys of a job. The parser takes the keys of each object from the table, and the published schema is
// made of the table, so that parser and schema have the same keys.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace kiln {

/// A key, and what its value may be, as a fragment of JSON Schema. In a fragment {"enum": "lattice"} stands for the
/// words of `kLatticeNames`, and so on, and {"$ref": "camera"} for the object of that name.
struct JobKey {
  std::string_view name, schema;
};
using JobKeys = std::span<const JobKey>;

namespace job_keys {
extern const JobKeys kCameraPath, kTurntable, kCameraKey, kFunctionKeys, kFunctionKey, kLightsKeys, kLightsKey,
    kClipKeys, kClipKey, kStereoKey, kVolume, kLabel;
extern const JobKeys kRoot, kImage, kCamera, kTransferFunction, kPoint, kGradientPoint, kShading, kLight, kHeadlight,
    kDirectionalLight, kPointLight, kClipPlane, kGradient, kVisibility, kExr, kPng, kOutput, kVideo, kStereo;
}  // namespace job_keys

/// JSON Schema (draft 2020-12) of a job. A job may also have comments, which a schema cannot describe.
std::string jobSchemaText();

}  // namespace kiln
