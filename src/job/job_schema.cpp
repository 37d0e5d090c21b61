// The published schema of a job: an object for each table of keys, and the few values that many keys share.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "job/job_keys.h"
#include "job/job_names.h"

namespace kiln {
namespace {

using nlohmann::ordered_json;

struct Object {
  const char* name;
  JobKeys keys;
  std::vector<std::string_view> required = {};
  JobKeys more = {};
  std::vector<std::string_view> one_of = {};  // exactly one of them is required
};

std::vector<Object> objects() {
  using namespace job_keys;
  return {{"job", kRoot},
          {"volume", kVolume, {"volume"}},
          {"image", kImage},
          {"camera", kCamera, {}, kCameraPath},
          {"turntable", kTurntable, {"frames"}},
          {"stereo", kStereo, {"eye"}, {}, {"interocular", "keyframes"}},
          {"stereoKeyframe", kStereoKey, {"frame", "interocular"}},
          {"cameraKeyframe", kCameraKey, {"frame"}, kCamera},
          {"functionKeyframes", kFunctionKeys, {"keyframes"}},
          {"functionKeyframe", kFunctionKey, {"frame", "function"}},
          {"lightsKeyframes", kLightsKeys, {"keyframes"}},
          {"lightsKeyframe", kLightsKey, {"frame", "lights"}},
          {"clipKeyframes", kClipKeys, {"keyframes"}},
          {"clipKeyframe", kClipKey, {"frame", "planes"}},
          {"transferFunction", kTransferFunction, {}, {}, {"points", "labels"}},
          {"label", kLabel, {"label", "color"}},
          {"point", kPoint, {"value", "color", "opacity"}},
          {"gradientPoint", kGradientPoint, {"gradient", "factor"}},
          {"shading", kShading},
          {"light", kLight, {"type"}},
          {"clipPlane", kClipPlane, {"normal", "offset"}},
          {"gradient", kGradient, {"top", "bottom"}},
          {"visibility", kVisibility},
          {"output", kOutput, {"path"}},
          {"video", kVideo},
          {"exr", kExr},
          {"png", kPng}};
}

constexpr JobKey kValues[] = {
    {"text", R"({"type": "string", "minLength": 1})"},
    {"fraction", R"({"type": "number", "minimum": 0, "maximum": 1})"},
    {"weight", R"({"type": "number", "minimum": 0, "maximum": 1000})"},
    {"brightness", R"({"type": "number", "minimum": 0, "maximum": 1000000})"},
    {"length", R"({"type": "number", "minimum": -1e30, "maximum": 1e30})"},
    {"positiveLength", R"({"type": "number", "exclusiveMinimum": 0, "maximum": 1e30})"},
    {"vector", R"({"type": "array", "items": {"$ref": "length"}, "minItems": 3, "maxItems": 3})"},
    {"rgba", R"({"type": "array", "items": {"$ref": "fraction"}, "minItems": 4, "maxItems": 4})"},
    {"pair", R"({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2})"},
};

std::span<const std::string_view> wordsOf(const std::string& name) {
  static constexpr std::array<std::string_view, 2> kColorSpaces = {"linear", "srgb"};
  if (name == "projection") return kProjectionNames;
  if (name == "side") return kSideNames;
  if (name == "visibility") return kVisibilityNames;
  if (name == "mode") return kModeNames;
  if (name == "lattice") return kLatticeNames;
  if (name == "interpolation") return kInterpolationNames;
  if (name == "shading") return kShadingNames;
  if (name == "light") return kLightNames;
  if (name == "aov") return kAovNames;
  if (name == "content") return kContentNames;
  if (name == "stereoEye") return kStereoEyeNames;
  if (name == "compression") return kExrCompressionNames;
  if (name == "ease") return kEaseNames;
  if (name == "pivot") return kPivotNames;
  if (name == "distribution") return kDistributionNames;
  if (name == "area") return kProjectedAreaNames;
  return kColorSpaces;
}

// Writes out what a fragment only names.
void expand(ordered_json& fragment) {
  if (!fragment.is_structured()) return;
  if (fragment.is_object() && fragment.contains("$ref"))
    fragment["$ref"] = "#/$defs/" + fragment["$ref"].get<std::string>();
  if (fragment.is_object() && fragment.contains("enum") && fragment["enum"].is_string())
    fragment["enum"] = wordsOf(fragment["enum"].get<std::string>());
  for (ordered_json& part : fragment) expand(part);
}

ordered_json expanded(const JobKey& key) {
  ordered_json out = ordered_json::parse(key.schema);
  expand(out);
  return out;
}

ordered_json schemaOf(const Object& object) {
  ordered_json out = {{"type", "object"}, {"properties", ordered_json::object()}};
  for (const JobKeys keys : {object.keys, object.more}) {
    for (const JobKey& key : keys) out["properties"][std::string(key.name)] = expanded(key);
  }
  if (!object.required.empty()) out["required"] = object.required;
  for (const std::string_view key : object.one_of) out["oneOf"].push_back({{"required", {key}}});
  out["additionalProperties"] = false;
  return out;
}

}  // namespace

std::string jobSchemaText() {
  ordered_json out = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                      {"title", fmt::format("A job of kiln render, version {}", KILN_VERSION)},
                      {"$ref", "#/$defs/job"},
                      {"oneOf", {{{"required", {"volume"}}}, {{"required", {"volumes"}}}}}};
  for (const Object& object : objects()) out["$defs"][object.name] = schemaOf(object);
  for (const JobKey& value : kValues) out["$defs"][std::string(value.name)] = expanded(value);
  return out.dump(1) + "\n";
}

}  // namespace kiln
