#include "job/command/job_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "image/named_color.h"
#include "job/command/given_flags.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "job/option_kinds.h"
#include "job/stated_job.h"

namespace kiln {
namespace {

using nlohmann::ordered_json;
using Texts = std::map<std::string, std::vector<std::string>>;  // by flag

// "a,b,c", a number or a word; empty for other values.
std::string simpleText(const ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number()) return fmt::format("{}", value.get<double>());
  if (!value.is_array()) return {};
  std::string out;
  for (const ordered_json& item : value) {
    const std::string text = item.is_structured() ? "" : simpleText(item);
    if (text.empty()) return {};
    out += (out.empty() ? "" : ",") + text;
  }
  return out;
}

std::string colorText(const glm::dvec3& color) { return fmt::format("{},{},{}", color.r, color.g, color.b); }

std::string functionText(const TransferFunctionChoice& choice) {
  if (const auto* const name = std::get_if<std::string>(&choice)) return *name;
  const auto* const function = std::get_if<TransferFunction>(&choice);
  if (function == nullptr) return {};
  std::string out;
  for (const TransferPoint& point : function->points)
    out += fmt::format("{}{}:{}:{}", out.empty() ? "" : ",", point.value, point.opacity, hexText(point.color));
  return out;
}

std::string lightText(const Light& light) {
  constexpr std::array<std::string_view, 4> kWords = {"headlight", "dir", "point", "cam"};
  std::string out(nameIn(kWords, light.kind));
  if (light.kind != LightKind::kHeadlight) out += fmt::format(":{},{},{}", light.place.x, light.place.y, light.place.z);
  return light.color == Light().color ? out : out + ":" + colorText(light.color);
}

// Adds the flags of values that differ from `plain`.
void addTexts(const Options<RenderJob>& options, const RenderJob& job, const RenderJob& plain, Texts& out) {
  for (const Option<RenderJob>& option : options) {
    addTexts(option.value.inside, job, plain, out);
    if (option.flag.empty() || option.key.empty() || !option.value.write) continue;
    const ordered_json value = option.value.write(job);
    if (value.is_null() || value == option.value.write(plain)) continue;
    if (option.value.form.arguments == JobFlag::Arguments::kNone)
      out[nameOfFlag(option.flag)] = {""};
    else if (const std::string text = value.is_boolean() ? (value.get<bool>() ? "on" : "off") : simpleText(value);
             !text.empty())
      out[nameOfFlag(option.flag)] = {text};
  }
}

Texts textsOf(const RenderJob& job, const RenderJob& plain) {
  Texts out;
  addTexts(jobOptions(), job, plain, out);
  const PictureOptions &picture = job.picture, &of_plain = plain.picture;
  if (const std::string text = functionText(picture.transfer_function); !text.empty() && text != "auto")
    out["--tf"] = {text};
  if (picture.background) {
    const auto text = [](const std::array<double, 4>& color) {
      return color[3] == 0 ? "transparent" : colorText({color[0], color[1], color[2]});
    };
    const auto& [top, bottom] = *picture.background;
    out["--background"] = {top == bottom ? text(top) : text(top) + ":" + text(bottom)};
  }
  if (const AmbientOcclusion& occlusion = picture.shading.occlusion; !(occlusion == of_plain.shading.occlusion))
    out["--ambient-occlusion"] = {occlusion.radius > 0 ? fmt::format("{}:{}", occlusion.strength, occlusion.radius)
                                                       : fmt::format("{}", occlusion.strength)};
  if (picture.shading.lights != of_plain.shading.lights) {
    out["--light"].clear();
    for (const Light& light : picture.shading.lights) out["--light"].push_back(lightText(light));
  }
  if (const auto& mask = job.companions.mask)
    out["--mask"] = {fmt::format("{}:{}", mask->volume.generic_string(), fmt::join(mask->labels, ","))};
  if (const auto& colors = job.companions.color_by)
    out["--color-by"] = {colors->volume.generic_string() + ":" + functionText(colors->transfer_function)};
  if (const auto& section = picture.clipping.section; section && section->opacity == Section().opacity) {
    const std::string window = section->window ? fmt::format("{},{}", section->window->x, section->window->y) : "";
    out["--section"] = {section->color_map.empty() ? "tf"
                        : window.empty()           ? section->color_map
                                                   : window + ":" + section->color_map};
  }
  const ordered_json stated = statedJson(job);
  if (stated.contains("worldRegion")) out["--world-region"] = {simpleText(stated["worldRegion"])};
  out.erase("--clip");
  for (std::size_t i = picture.clipping.box_faces; i < picture.clipping.planes.size(); ++i) {
    const ClipPlane& plane = picture.clipping.planes[i];
    out["--clip"].push_back(fmt::format("{},{},{},{}", plane.normal.x, plane.normal.y, plane.normal.z, plane.offset));
  }
  if (const auto* const turntable = std::get_if<Turntable>(&job.animation.camera))
    out["--turntable"] = {fmt::format("{}", turntable->frames)};
  return out;
}

// Returns a job without options: size, memory and threads are not stated.
RenderJob withoutOptions(const RenderJob& job) {
  // GCC 12 warns of lights without a value where a job is made in place.
  static const RenderJob kDefaults;
  RenderJob out = kDefaults;
  out.picture.size = job.picture.size;
  out.speed = job.speed;
  out.speed.visibility = {};
  return out;
}

// Returns whether the flags make the job of a job without options.
bool makes(const RenderJob& job, const Texts& texts) {
  RenderJob made = withoutOptions(job);
  try {
    for (const JobFlag& flag : jobFlags()) {
      const auto found = texts.find(nameOfFlag(flag.flag));
      if (found == texts.end()) continue;
      // No option states an empty list, such as that of a picture without lights.
      if (found->second.empty()) return false;
      flag.apply(found->second, made);
    }
  } catch (const Error&) {
    return false;
  }
  return statedJson(made) == statedJson(job);
}

std::vector<std::string> inOrder(const Texts& texts) {
  std::vector<std::string> out;
  for (const JobFlag& flag : jobFlags()) {
    const auto found = texts.find(nameOfFlag(flag.flag));
    if (found == texts.end()) continue;
    for (const std::string& text : found->second) {
      out.push_back(nameOfFlag(flag.flag));
      if (flag.arguments != JobFlag::Arguments::kNone) out.push_back(text);
    }
  }
  return out;
}

}  // namespace

std::optional<std::vector<std::string>> optionsOf(const RenderJob& given) {
  if (!given.volumes.empty()) return std::nullopt;
  RenderJob job = given;
  job.output = encodingsOf(given.output);
  job.frames.clear();
  for (const std::string_view look : kLookNames) {
    RenderJob plain = withoutOptions(job);
    const bool is_plain = look == kLookNames[0];
    if (!is_plain) {
      for (const JobFlag& flag : jobFlags()) {
        if (nameOfFlag(flag.flag) == "--look") flag.apply({std::string(look)}, plain);
      }
    }
    Texts texts = textsOf(job, plain);
    if (!is_plain) texts["--look"] = {std::string(look)};
    if (makes(job, texts)) return inOrder(texts);
  }
  return std::nullopt;
}

}  // namespace kiln
