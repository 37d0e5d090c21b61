#include "job/transfer_function_choice.h"

#include <algorithm>

#include "base/error.h"
#include "base/file/file.h"
#include "base/text.h"
#include "job/json/paraview_map.h"
#include "job/json/points_text.h"
#include "job/transfer_function_json.h"
#include "scene/transfer/label_styles.h"
#include "scene/transfer/preset_ranges.h"
#include "scene/transfer/presets.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kLargestFile_bytes = 16u << 20;

struct FileAndName {
  fs::path file;
  std::string name;  // empty if absent
};

// A '#' is part of the file's name if such a file exists.
FileAndName parted(const fs::path& given) {
  const std::string text = given.string();
  const std::size_t hash = text.rfind('#');
  std::error_code ignored;
  if (hash == std::string::npos || fs::exists(given, ignored)) return {given, ""};
  return {text.substr(0, hash), text.substr(hash + 1)};
}

std::string nameOf(const JobObject& map) { return map.text("Name", "a name").value_or(""); }

const JobObject& chosen(const std::vector<JobObject>& maps, const FileAndName& from) {
  if (maps.empty()) throw Error(ErrorCode::kUsage, from.file, "", "holds an empty list and no transfer function");
  if (from.name.empty() && maps.size() == 1) return maps.front();
  std::string names;
  for (const JobObject& map : maps) {
    if (!from.name.empty() && nameOf(map) == from.name) return map;
    names += (names.empty() ? "" : ", ") + nameOf(map);
  }
  if (names.empty())
    throw Error(ErrorCode::kUsage, from.file, "",
                "holds no map named '" + from.name + "', and none that has a name; leave it out");
  constexpr std::size_t kLongest = 300;
  if (names.size() > kLongest) {
    names.resize(kLongest);
    names += "…";
  }
  const std::string sentence = from.name.empty() ? "holds several maps; write FILE#NAME with one of: "
                                                 : "holds no map named '" + from.name + "'; there are ";
  throw Error(ErrorCode::kUsage, from.file, "", sentence + names);
}

TransferFunction functionOf(ParaViewMap map, const Manifest& manifest) {
  if (map.normalised()) {
    const ValueRange range = map.opacity ? usableRange(manifest) : colorMapRange(manifest);
    stretch(map.colors, {0, 1}, range);
    if (map.opacity) stretch(*map.opacity, {0, 1}, range);
  }
  if (!map.opacity)
    map.opacity = risingOpacity({map.colors.nodes.front().value, map.colors.nodes.back().value}, manifest);
  return {0, sampled(map.colors, *map.opacity)};
}

template <class Entry>
void fitInto(const Window& window, std::vector<Entry>& entries) {
  if (entries.empty()) return;
  const ValueRange from{entries.front().value, entries.back().value};
  const ValueRange to{window.centre - 0.5 * window.width, window.centre + 0.5 * window.width};
  if (from.lo < from.hi) {
    stretch(entries, from, to);
  } else {
    for (Entry& entry : entries) entry.value = window.centre;
  }
}

}  // namespace

std::optional<TransferFunctionChoice> writtenChoice(const std::string& text) {
  if (isPreset(text)) {
    requirePresetNumbers(text);
    return text;
  }
  if (isPointsText(text)) return functionOfPoints(text);
  return std::nullopt;
}

fs::path fileOf(const fs::path& file_and_name) { return parted(file_and_name).file; }

TransferFunction readTransferFunction(const fs::path& file_and_name, const Manifest& manifest) {
  const auto [file, name] = parted(file_and_name);
  return transferFunctionOfText(readTextFile(file, kLargestFile_bytes), manifest, file, name);
}

TransferFunction transferFunctionOfText(const std::string& text, const Manifest& manifest, const fs::path& path,
                                        const std::string& name) {
  const FileAndName from{path, name};
  if (from.name.empty() && isLabelDescription(text)) return labelDescription(text, from.file);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && std::string_view("{[/\xef").find(text[first]) == std::string_view::npos)
    throw Error(ErrorCode::kFormat, from.file, "",
                "expected a transfer function in JSON, which begins with { or [, or a label description, "
                "whose lines begin with a number (found '" +
                    shown(text.substr(first, std::min<std::size_t>(text.find('\n', first) - first, 40))) +
                    "'); name another file");
  const std::vector<JobObject> maps = JobObject::parseSeveral(text, from.file);
  const JobObject& map = chosen(maps, from);
  return isParaViewMap(map) ? functionOf(paraViewMapFrom(map), manifest) : transferFunctionFrom(map);
}

TransferFunction functionFor(const TransferFunctionChoice& choice, const std::optional<Window>& window,
                             const Manifest& manifest) {
  TransferFunction out;
  if (const auto* name = std::get_if<std::string>(&choice)) {
    out = presetFor(*name, manifest);
  } else if (const auto* path = std::get_if<fs::path>(&choice)) {
    out = readTransferFunction(*path, manifest);
  } else {
    out = std::get<TransferFunction>(choice);
  }
  requireFitting(out, window.has_value(), manifest);
  if (window) {
    fitInto(*window, out.points);
    fitInto(*window, out.surfaces);
  }
  return out;
}

TransferFunction resolve(const TransferFunctionChoice& choice, const std::optional<Window>& window,
                         const Manifest& manifest) {
  TransferFunction out = functionFor(choice, window, manifest);
  out.unit = out.unitIn(manifest.ownMeanSpacing());
  return out;
}

}  // namespace kiln
