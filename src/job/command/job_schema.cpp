// The schema is made of the tables of options: a definition per object, and ranges that many keys share.
#include "job/command/job_schema.h"

#include <fmt/format.h>

#include <span>
#include <string>
#include <string_view>

#include "image/named_color.h"
#include "job/job_options.h"

namespace kiln {
namespace {

using nlohmann::ordered_json;

template <class Owner>
void addObject(std::string_view name, const Options<Owner>& options, ordered_json& definitions) {
  ordered_json properties = ordered_json::object(), required = ordered_json::array();
  for (const Option<Owner>& option : options) {
    if (option.key.empty()) continue;
    ordered_json schema = option.value.form.schema;
    if (!option.help.empty()) schema["description"] = option.help;
    properties[std::string(option.key)] = std::move(schema);
    if (!option.missing.empty()) required.push_back(option.key);
    if (!option.value.inside.empty()) addObject(option.value.name, option.value.inside, definitions);
  }
  ordered_json out = {{"type", "object"}, {"properties", std::move(properties)}};
  if (!required.empty()) out["required"] = std::move(required);
  out["additionalProperties"] = false;
  definitions[std::string(name)] = std::move(out);
}

ordered_json requiring(const char* key) { return {{"required", {key}}}; }

// A point light has a position, as the parser requires.
void requirePosition(ordered_json& light) {
  light["if"] = {{"properties", {{"type", {{"const", "point"}}}}}, {"required", {"type"}}};
  light["then"] = requiring("position");
}

// A pattern of the names in letters of any case.
std::string patternOfNames(std::span<const std::string_view> names) {
  std::string out = "^(";
  for (const std::string_view name : names) {
    if (out.size() > 2) out += '|';
    for (const char c : name) out += fmt::format("[{}{}]", c, static_cast<char>(c - 'a' + 'A'));
  }
  return out + ")$";
}

// An object that holds keys at frames only.
void addKeyframes(const std::string& name, const std::string& key, ordered_json& definitions) {
  definitions[name] = {{"type", "object"},
                       {"properties", {{"keyframes", keyframesSchema(key)}}},
                       {"required", {"keyframes"}},
                       {"additionalProperties", false}};
}

constexpr const char* kColorPattern = "^#[0-9A-Fa-f]{3}([0-9A-Fa-f]{3})?$";

constexpr const char* kShared = R"({
  "backgroundColor": {"anyOf": [{"const": "transparent"}, {"$ref": "colorName"}, {"$ref": "rgba"}]},
  "gradient": {"type": "object", "properties": {"top": {"$ref": "backgroundColor"}, "bottom": {"$ref": "backgroundColor"}},
               "required": ["top", "bottom"], "additionalProperties": false},
  "text": {"type": "string", "minLength": 1},
  "vector": {"type": "array", "items": {"$ref": "length"}, "minItems": 3, "maxItems": 3},
  "rgba": {"type": "array", "items": {"$ref": "fraction"}, "minItems": 4, "maxItems": 4},
  "pair": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}})";

// Names of definitions become references.
void expandReferences(ordered_json& part) {
  if (part.is_object() && part.contains("$ref")) part["$ref"] = "#/$defs/" + part["$ref"].get<std::string>();
  if (!part.is_structured()) return;
  for (ordered_json& inner : part) expandReferences(inner);
}

}  // namespace

std::string jobSchemaText() {
  ordered_json definitions;
  addObject("job", jobOptions(), definitions);
  addObject("volume", volumeOptions(), definitions);
  addObject("output", outputFileOptions(), definitions);
  addObject("turntable", turntableOptions(), definitions);
  addObject("cameraKeyframe", cameraKeyOptions(), definitions);
  addObject("stereoKeyframe", stereoKeyOptions(), definitions);
  addObject("functionKeyframe", functionKeyOptions(), definitions);
  addObject("lightsKeyframe", lightsKeyOptions(), definitions);
  addObject("clipKeyframe", clipKeyOptions(), definitions);
  addKeyframes("functionKeyframes", "functionKeyframe", definitions);
  addKeyframes("lightsKeyframes", "lightsKeyframe", definitions);
  addKeyframes("clipKeyframes", "clipKeyframe", definitions);
  addObject("transferFunction", transferFunctionOptions(), definitions);
  addObject("point", pointOptions(), definitions);
  addObject("isoSurface", surfaceOptions(), definitions);
  addObject("gradientPoint", gradientPointOptions(), definitions);
  addObject("gradientRegion", gradientRegionOptions(), definitions);
  addObject("label", labelOptions(), definitions);
  addObject("light", lightOptions(), definitions);
  addObject("shadow", shadowOptions(), definitions);
  addObject("ambientOcclusion", occlusionOptions(), definitions);
  addObject("clipPlane", clipPlaneOptions(), definitions);
  // Regions and a table need no points.
  const ordered_json of_points = {{"anyOf", {requiring("points"), requiring("regions"), requiring("table")}}};
  definitions["transferFunction"]["oneOf"] = {of_points, requiring("surfaces"), requiring("labels")};
  definitions["stereo"]["oneOf"] = {requiring("interocular"), requiring("keyframes")};
  requirePosition(definitions["light"]);
  for (const SharedRange& range : sharedRanges())
    definitions[std::string(range.name)] = Number{range.range}.form().schema;
  definitions.update(ordered_json::parse(kShared));
  definitions["colorName"]["anyOf"] = {{{"enum", colorNames()}},
                                       {{"type", "string"}, {"pattern", patternOfNames(colorNames())}},
                                       {{"type", "string"}, {"pattern", kColorPattern}}};
  ordered_json out = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                      {"title", fmt::format("A job of kiln render, version {}", KILN_VERSION)},
                      {"$ref", "job"},
                      {"oneOf", {{{"required", {"volume"}}}, {{"required", {"volumes"}}}}}};
  out["$defs"] = std::move(definitions);
  expandReferences(out);
  return out.dump(1) + "\n";
}

}  // namespace kiln
