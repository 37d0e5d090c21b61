#include "unknown_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "job/json/job_json.h"

namespace kiln::tool {
namespace {

// Names in ParaView, Blender, F3D, ffmpeg and other renderers. Only pairs whose second option the command has count.
constexpr std::array<std::pair<std::string_view, std::string_view>, 18> kSynonyms = {{
    {"--bg", "--background"},
    {"--background-color", "--background"},
    {"--resolution", "--size"},
    {"--width", "--size"},
    {"--height", "--size"},
    {"--camera-position", "--eye"},
    {"--camera-focal-point", "--target"},
    {"--camera-view-up", "--up"},
    {"--camera-view-angle", "--fov"},
    {"--transfer-function", "--tf"},
    {"--colormap", "--tf"},
    {"--preset", "--tf"},
    {"--crop-box", "--region"},
    {"--roi", "--region"},
    {"--fps", "--rate"},
    {"--step", "--sample-distance"},
    {"--jobs", "--threads"},
    {"--force", "--overwrite"},
}};

std::vector<std::string> longOptionsOf(const CLI::App& command) {
  std::vector<std::string> out;
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
  }
  return out;
}

// The option of the same meaning, or whose name begins alike, or differs in a few letters.
std::optional<std::string_view> proposalFor(std::string_view word, const std::vector<std::string>& options) {
  const auto has = [&](std::string_view name) {
    return std::find(options.begin(), options.end(), name) != options.end();
  };
  for (const auto& [other, ours] : kSynonyms) {
    if (word == other && has(ours)) return ours;
  }
  const std::vector<std::string_view> names(options.begin(), options.end());
  if (names.empty()) return std::nullopt;
  for (const std::string_view name : names) {
    if (name.starts_with(word)) return name;
  }
  const std::string_view nearest = nearestWord(word, names);
  const auto common = std::mismatch(word.begin(), word.end(), nearest.begin(), nearest.end()).first - word.begin();
  return common >= 3 ? std::optional(nearest) : std::nullopt;
}

}  // namespace

std::string unknownOptionText(const CLI::App& app) {
  for (const CLI::App* const command : app.get_subcommands()) {
    for (const std::string& word : command->remaining()) {
      if (!word.starts_with("--")) continue;
      const std::string name = word.substr(0, word.find('='));
      const std::vector<std::string> options = longOptionsOf(*command);
      const auto proposal = proposalFor(name, options);
      return fmt::format(
          "{}: is no option of kiln {}; {}", name, command->get_name(),
          proposal ? fmt::format("{}?", *proposal) : fmt::format("run 'kiln {} --help'", command->get_name()));
    }
  }
  return "";
}

}  // namespace kiln::tool
