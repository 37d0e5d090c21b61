#include "ingest/source/chosen_part.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/text.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr std::size_t kMostNames = 12;

// Returns "0 (DAPI), 1, 2"; nothing if no channel has a name.
std::string listOf(std::span<const std::string> names) {
  const auto named = [](const std::string& name) { return !name.empty(); };
  if (std::none_of(names.begin(), names.end(), named)) return "";
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i)
    out += fmt::format("{}{}{}", i == 0 ? ": " : ", ", i, names[i].empty() ? "" : " (" + inQuotes(names[i]) + ")");
  return names.size() > kMostNames ? out + fmt::format(" and {} more", names.size() - kMostNames) : out;
}

[[noreturn]] void refuseChoice(const std::filesystem::path& file, const char* option, const std::string& what) {
  throw Error(ErrorCode::kUsage, file, option, what);
}

}  // namespace

UnchosenPart::UnchosenPart(const char* part, const std::filesystem::path& file, std::int64_t count,
                           const std::string& names)
    : Error(ErrorCode::kUsage, file, "",
            fmt::format("holds {0} {1}s; choose one with --{1}, from 0 to {2}{3}", count, part, count - 1, names)),
      part_(part),
      parts_(fmt::format("{} {}s{}", count, part, names)) {}

std::int64_t chosenTime(const SourceOptions& options, std::int64_t count, const std::filesystem::path& file) {
  if (!options.time) {
    if (count == 1) return 0;
    throw UnchosenPart("time", file, count, "");
  }
  if (*options.time < 0 || *options.time >= count)
    refuseChoice(file, "--time", fmt::format("expected a number from 0 to {} (found {})", count - 1, *options.time));
  return *options.time;
}

std::int64_t chosenChannel(const SourceOptions& options, std::span<const std::string> names,
                           const std::filesystem::path& file) {
  const auto count = static_cast<std::int64_t>(names.size());
  if (!options.channel) {
    if (count == 1) return 0;
    throw UnchosenPart("channel", file, count, listOf(names));
  }
  if (const auto number = numberOf<std::int64_t>(*options.channel); number && *number >= 0 && *number < count)
    return *number;
  const auto named = std::find(names.begin(), names.end(), *options.channel);
  if (named == names.end() || named->empty())
    refuseChoice(
        file, "--channel",
        fmt::format("{} is none of the channels 0 to {}{}", inQuotes(*options.channel), count - 1, listOf(names)));
  if (std::find(named + 1, names.end(), *options.channel) != names.end())
    refuseChoice(file, "--channel",
                 fmt::format("{} names several channels; choose one by its number, from 0 to {}{}",
                             inQuotes(*options.channel), count - 1, listOf(names)));
  return named - names.begin();
}

std::int64_t chosenScale(const SourceOptions& options, std::int64_t count, const std::filesystem::path& file) {
  const std::int64_t scale = options.scale.value_or(0);
  if (scale < 0 || scale >= count)
    refuseChoice(file, "--scale", fmt::format("must be a number from 0 to {} (found {})", count - 1, scale));
  return scale;
}

std::string partOf(const char* kind, std::int64_t part, std::int64_t count) {
  return count > 1 ? fmt::format(", {} {}", kind, part) : "";
}

}  // namespace kiln
