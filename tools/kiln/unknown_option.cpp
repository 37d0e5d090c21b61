#include "unknown_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/nearest_word.h"
#include "base/shell_text.h"

namespace kiln::tool {
namespace {

// Names in ParaView, Blender, F3D, ffmpeg and other renderers. Only pairs whose second option the command has count.
constexpr std::array<std::pair<std::string_view, std::string_view>, 20> kSynonyms = {{
    {"bg", "background"},
    {"background-color", "background"},
    {"resolution", "size"},
    {"width", "size"},
    {"height", "size"},
    {"camera-position", "eye"},
    {"camera-focal-point", "target"},
    {"camera-view-up", "up"},
    {"camera-view-angle", "fov"},
    {"transfer-function", "tf"},
    {"colormap", "tf"},
    {"preset", "tf"},
    {"crop-box", "region"},
    {"roi", "region"},
    {"fps", "rate"},
    {"step", "sample-distance"},
    {"jobs", "threads"},
    {"force", "overwrite"},
    {"threshold", "tf"},
    {"font-size", "annotation-size"},
}};

std::vector<std::string> longOptionsOf(const CLI::App& command) {
  std::vector<std::string> out;
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) out.push_back(name);
  }
  return out;
}

// The option of the same meaning, or whose name begins alike, or differs in a few letters; without its dashes.
std::optional<std::string_view> proposalFor(std::string_view word, const std::vector<std::string>& options) {
  const auto has = [&](std::string_view name) {
    return std::find(options.begin(), options.end(), name) != options.end();
  };
  for (const auto& [other, ours] : kSynonyms) {
    if (word == other && has(ours)) return ours;
  }
  const std::vector<std::string_view> names(options.begin(), options.end());
  return meantWord(word, names);
}

// Returns the remedy for words beyond those that a command takes; `word` is the first of them.
std::string remedyFor(const CLI::App& command, const std::string& word) {
  const CLI::Option* const output = command.get_option_no_throw("--output");
  std::error_code ignored;
  const bool is_input = word.ends_with(".kiln") || std::filesystem::exists(word, ignored);
  if (output != nullptr && output->results().empty() && !is_input)
    return fmt::format("-o {} names the file to write", shellText(word));
  const std::string name = command.get_name();
  if (name == "convert") return "convert one volume at a time, and name slices by their folder";
  if (command.get_option_no_throw("--add") != nullptr)
    return fmt::format("--add {} shows a further volume", shellText(word));
  const bool takes_none = std::ranges::none_of(command.get_options(), &CLI::Option::get_positional);
  return takes_none ? "leave the words out" : fmt::format("run kiln {} for one after the other", name);
}

// The sentence for words beyond those that the command takes; empty if there are none.
std::string surplusText(const CLI::App& command) {
  const std::vector<std::string> left = command.remaining();
  if (left.empty() || left.front().starts_with('-')) return "";
  std::string expected, found;
  for (const CLI::Option* const option : command.get_options()) {
    if (!option->get_positional()) continue;
    expected += (expected.empty() ? "" : " and ") + option->get_name(true);
    for (const std::string& word : option->results()) found += shellText(word) + " ";
  }
  if (expected.empty()) expected = "options only";
  for (const std::string& word : left) found += shellText(word) + " ";
  found.pop_back();
  return fmt::format("{}: expected {} (found {}); {}", command.get_name(), expected, found,
                     remedyFor(command, left.front()));
}

}  // namespace

std::string unknownCommandText(const CLI::App& app, const std::string& word) {
  std::vector<std::string_view> names;
  for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  const std::string hint = meantWordHint(word, names);
  return fmt::format("there is no command or option '{}'{}", word, hint.empty() ? "; run 'kiln --help'" : hint);
}

std::string unknownOptionText(const CLI::App& app) {
  for (const CLI::App* const command : app.get_subcommands()) {
    for (const std::string& word : command->remaining()) {
      if (!word.starts_with("--")) continue;
      const std::string name = word.substr(2, word.find('=') - 2);
      const std::vector<std::string> options = longOptionsOf(*command);
      const auto proposal = proposalFor(name, options);
      return fmt::format(
          "--{}: is no option of kiln {}; {}", name, command->get_name(),
          proposal ? fmt::format("--{}?", *proposal) : fmt::format("run 'kiln {} --help'", command->get_name()));
    }
    if (const std::string surplus = surplusText(*command); !surplus.empty()) return surplus;
  }
  return "";
}

std::string repeatedOptionText(const CLI::App& app) {
  for (const CLI::App* const command : app.get_subcommands()) {
    for (const CLI::Option* const option : command->get_options()) {
      const std::vector<std::string>& values = option->results();
      if (option->get_expected_max() == 1 && values.size() > 1)
        return fmt::format("{}: takes one value (found {} and {}); give the option once", option->get_name(),
                           shellText(values[0]), shellText(values[1]));
    }
  }
  return "";
}

}  // namespace kiln::tool
