#include "job/transfer_function_json.h"

#include <fmt/format.h>

#include <optional>
#include <set>

#include "image/srgb.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "scene/transfer/label_styles.h"
#include "store/manifest/json_text.h"

namespace kiln {
namespace {

// True if numbers of colours are sRGB. A document without a number of its format has format 1.
bool hasSrgbNumbers(const JobObject& function) {
  if (const auto place = function.choice("colorSpace", kColorSpaceNames)) return *place == 1;
  return function.format().value_or(1) >= 2;
}

void decode(glm::dvec3& color) { color = linearFromSrgb(color); }
void decode(std::optional<glm::dvec3>& color) { color = linearFromSrgb(*color); }

// Decodes the colours that are numbers; texts were decoded when they were read.
template <class Item>
void decodeNumbers(const JobObject& function, std::string_view list, std::vector<Item>& items) {
  if (items.empty()) return;
  const auto objects = *function.objects(list, list, {items.size(), list});
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (objects[i].has("color") && !objects[i].isText("color")) decode(items[i].color);
  }
}

// A list with a line for each item.
std::string linesOfJson(const nlohmann::ordered_json& list) {
  std::string out;
  for (const nlohmann::ordered_json& item : list) out += (out.empty() ? "[\n    " : ",\n    ") + jsonText(item, -1);
  return out + "]";
}

void requireOnce(const JobObject& object, const std::vector<LabelStyle>& labels) {
  std::set<double> known;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (known.insert(labels[i].label).second) continue;
    object.objects("labels", "labels", {labels.size(), "labels"})->at(i).complain("label", "is given twice");
  }
}

// Opacity depends on the gradient in one of three ways.
void requireOnePlane(const JobObject& object) {
  const char* first = nullptr;
  for (const char* key : {"gradientOpacity", "regions", "table"}) {
    if (!object.has(key)) continue;
    if (first != nullptr) object.complain(key, fmt::format("contradicts {}; leave one of them out", first));
    first = key;
  }
}

}  // namespace

TransferFunction transferFunctionFrom(const JobObject& object) {
  TransferFunction out;
  if (object.has("labels")) {
    for (const char* key : {"points", "surfaces", "gradientOpacity", "regions", "table", "scattering"}) {
      if (object.has(key)) object.complain(key, "contradicts labels; a function has points, surfaces or labels");
    }
  }
  if (object.has("surfaces")) {
    for (const char* key : {"points", "gradientOpacity", "regions", "table", "scattering"}) {
      if (object.has(key)) object.complain(key, "contradicts surfaces; a function has points, surfaces or labels");
    }
  }
  requireOnePlane(object);
  readOptions(transferFunctionOptions(), object, out);
  // An empty object.
  if (object.has("scattering") && !out.scattering) out.scattering.emplace();
  if (out.scattering && !out.shaded)
    object.complain("shading", "is none, which contradicts scattering; leave one of them out");
  const bool has_plane = object.has("regions") || object.has("table");
  if (out.labels.empty() && out.surfaces.empty() && out.points.empty() && !has_plane)
    object.refuse("points", "a list of at least one point {value, color, opacity}");
  if (hasSrgbNumbers(object)) {
    decodeNumbers(object, "points", out.points);
    decodeNumbers(object, "surfaces", out.surfaces);
    decodeNumbers(object, "labels", out.labels);
    decodeNumbers(object, "regions", out.regions);
  }
  if (has_plane && out.points.empty()) out.points.push_back({0, glm::dvec3(1), 1});
  requireOnce(object, out.labels);
  sortLabels(out.labels);
  return out;
}

std::string transferFunctionText(const TransferFunction& function) {
  nlohmann::ordered_json values = {{"kiln", kJobFormat}};
  values.update(resolvedJson(transferFunctionOptions(), function));
  std::string out;
  for (const auto& [key, value] : values.items())
    out += fmt::format("{}\n  \"{}\": {}", out.empty() ? "{" : ",", key,
                       value.is_array() ? linesOfJson(value) : jsonText(value, -1));
  return out + "\n}\n";
}

}  // namespace kiln
