// Lines "Key=Value" in sections, in an 8-bit encoding. The section [Acquisition] has the pixels of the projections,
// which are no slices. Slices taken from a longer stack, such as every second, are further apart than the log states:
// the numbers of their names decide.
#include "ingest/tiff/skyscan_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/file/file.h"
#include "base/text.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

std::optional<ReconstructionLog> readLog(const fs::path& path) {
  constexpr std::uint64_t kMost = 1 << 20;
  try {
    return reconstructionLogOf(readTextFile(path, kMost));
  } catch (const Error&) {
    return std::nullopt;  // unreadable, or too long to be a log
  }
}

// Returns the number at the end of a file's name; nothing without one.
std::optional<std::int64_t> sliceNumberOf(const fs::path& file) {
  const std::string stem = file.stem().string();
  return integerOf(std::string_view(stem).substr(stem.find_last_not_of("0123456789") + 1));
}

// The distance of slices by the numbers of their names; 1 if it is unknown. unit: slices.
std::int64_t stepOfNames(const std::vector<fs::path>& files) {
  if (files.size() < 2) return 1;
  const std::optional<std::int64_t> first = sliceNumberOf(files[0]), second = sliceNumberOf(files[1]);
  return first && second ? std::max<std::int64_t>(*second - *first, 1) : 1;
}

bool isNamedLike(const fs::path& log, const fs::path& slice) {
  return slice.filename().string().starts_with(log.stem().string());
}

std::string quoted(const fs::path& path) { return inQuotes(path.filename().string()); }

}  // namespace

std::optional<ReconstructionLog> reconstructionLogOf(std::string_view text) {
  ReconstructionLog out;
  bool inside = false;
  for (const std::string_view line : splitAt(text, '\n')) {
    const std::string whole = trimmed(line);
    if (whole.starts_with('[')) inside = whole == "[Reconstruction]";
    const std::size_t equals = whole.find('=');
    if (!inside || equals == std::string::npos) continue;
    const std::string key = trimmed(whole.substr(0, equals)), value = trimmed(whole.substr(equals + 1));
    if (key == "Pixel Size (um)") out.pixel_um = doubleOf(value).value_or(0);
    if (key == "Section to Section Step")
      out.step = std::clamp<std::int64_t>(integerOf(value).value_or(1), 1, 1'000'000);
    if (key == "Result Image Width (pixels)") out.width = integerOf(value).value_or(0);
    if (key == "Result Image Height (pixels)") out.height = integerOf(value).value_or(0);
  }
  constexpr double kLeast_um = 1e-6, kMost_um = 1e6;
  if (!(out.pixel_um > kLeast_um && out.pixel_um < kMost_um)) return std::nullopt;
  return out;
}

std::optional<LoggedSpacing> loggedSpacing(const SliceFiles& slices, std::int64_t width, std::int64_t height,
                                           std::vector<std::string>& notes) {
  struct Found {
    fs::path path;
    ReconstructionLog log;
  };
  std::vector<Found> found;
  for (const fs::path& path : slices.logs) {
    const std::optional<ReconstructionLog> log = readLog(path);
    if (!log) {
      notes.push_back(fmt::format("passed over {}, which states no size of reconstructed pixels", quoted(path)));
    } else if ((log->width != 0 && log->width != width) || (log->height != 0 && log->height != height)) {
      notes.push_back(fmt::format("passed over {}, which is of slices of {} x {} pixels (found {} x {})", quoted(path),
                                  log->width, log->height, width, height));
    } else {
      found.push_back({path, *log});
    }
  }
  const auto unlike = [&](const Found& one) { return !isNamedLike(one.path, slices.files.front()); };
  if (!std::all_of(found.begin(), found.end(), unlike)) std::erase_if(found, unlike);
  if (found.empty()) return std::nullopt;
  const auto spacingOf = [&](const ReconstructionLog& log) {
    const auto step = static_cast<double>(std::max(log.step, stepOfNames(slices.files)));
    return glm::dvec3(log.pixel_um, log.pixel_um, step * log.pixel_um);
  };
  const Found& first = found.front();
  for (const Found& other : found) {
    if (spacingOf(other.log) == spacingOf(first.log)) continue;
    notes.push_back(fmt::format("the logs {} and {} state different sizes of a voxel, of which none is taken",
                                quoted(first.path), quoted(other.path)));
    return std::nullopt;
  }
  return LoggedSpacing{spacingOf(first.log), first.path};
}

}  // namespace kiln
