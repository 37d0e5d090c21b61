// The options of cut faces.
#include <fmt/format.h>

#include <algorithm>

#include "job/job_options.h"
#include "job/job_parts.h"
#include "scene/transfer/display_map.h"

namespace kiln {
namespace {

constexpr std::string_view kOfFunction = "tf", kNone = "off";

OptionForm colorMapForm() {
  OptionForm form;
  form.schema = {{"enum", displayMapNames()}};
  return form;
}

bool isMap(std::string_view name) {
  const std::vector<std::string> names = displayMapNames();
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

const Options<Section>& sectionOptions() {
  using Row = Option<Section>;
  static const Options<Section> kOptions = {
      Row("window",
          OptionValue<Section>::custom(
              ValueWindow{}.form(),
              [](const JobObject& object, std::string_view key, Section& section) {
                std::optional<Window> window;
                ValueWindow{}.read(object, key, window);
                section.window = {window->centre, window->width};
                if (section.color_map.empty()) section.color_map = displayMapNames().front();
              },
              [](const Section& section) -> nlohmann::ordered_json {
                if (!section.window) return {};
                return {section.window->x, section.window->y};
              })
              .resolvedIf([](const Section& section) { return section.window.has_value(); }),
          "Values of the first and the last colour, [centre, width]; by default of the middle 99 % of the values."),
      Row("colormap",
          OptionValue<Section>::custom(
              colorMapForm(),
              [](const JobObject& object, std::string_view key, Section& section) {
                const std::vector<std::string> names = displayMapNames();
                const std::vector<std::string_view> words(names.begin(), names.end());
                section.color_map = names[*object.choice(key, words)];
              },
              [](const Section& section) {
                return section.color_map.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(section.color_map);
              })
              .resolvedIf([](const Section& section) { return !section.color_map.empty(); }),
          "Colours of the window, gray where none is given. Without window and colormap a face has the colours of the "
          "transfer function."),
      Row("opacity", {KILN_MEMBER(opacity), Number{{0, 1}, "", "fraction"}, kAlways}, "Opacity of the face."),
  };
  return kOptions;
}

OptionForm sectionForm() {
  OptionForm form;
  form.schema = {{"anyOf", {{{"type", "boolean"}}, {{"$ref", "section"}}}}};
  form.value_name = "tf|CENTRE,WIDTH[:COLORMAP]|COLORMAP|off";
  form.words = displayMapNames();
  form.words.insert(form.words.begin(), std::string(kOfFunction));
  form.words.emplace_back(kNone);
  form.expected =
      fmt::format("tf, CENTRE,WIDTH, CENTRE,WIDTH:COLORMAP, COLORMAP or off, the width above 0, COLORMAP one of {}",
                  fmt::join(displayMapNames(), ", "));
  form.parse = [](const std::string& text) -> nlohmann::json {
    if (text == kOfFunction || text == "on") return true;  // "on" is a job's true
    if (text == kNone) return false;
    const std::size_t colon = text.find(':');
    const bool windowed = text.find(',') != std::string::npos;
    nlohmann::json out = nlohmann::json::object();
    if (windowed) {
      out["window"] = numbersOfText(text.substr(0, colon));
      if (out["window"].is_null()) return {};
    }
    if (windowed && colon == std::string::npos) return out;
    out["colormap"] = windowed ? text.substr(colon + 1) : text;
    return isMap(out["colormap"].get<std::string>()) ? out : nlohmann::json();
  };
  return form;
}

void readSection(const JobObject& owner, std::string_view key, std::optional<Section>& out) {
  out.reset();
  if (owner.isObject(key)) {
    readOptions(sectionOptions(), *owner.object(key), out.emplace());
  } else if (*owner.flag(key)) {
    out.emplace();
  }
}

}  // namespace kiln
