#include "picture_job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "image/file/image_file.h"
#include "sequence/sequence_frames.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

// Returns the places at which a volume of the picture may be, the likeliest first.
std::vector<fs::path> placesOf(const fs::path& volume, const fs::path& picture) {
  const fs::path folder = picture.parent_path();
  const fs::path named = withoutTrailingSlash(volume);
  std::vector<fs::path> out{folder / named, folder / named.filename(), named};
  for (auto place = out.begin() + 1; place != out.end();)
    place = std::find(out.begin(), place, *place) != place ? out.erase(place) : place + 1;
  return out;
}

fs::path foundVolume(const fs::path& volume, const fs::path& picture) {
  const std::vector<fs::path> places = placesOf(volume, picture);
  const auto found = std::find_if(places.begin(), places.end(), [](const fs::path& place) { return isThere(place); });
  if (found != places.end()) return *found;
  std::vector<std::string> names;
  for (const fs::path& place : places) names.push_back(place.string());
  throw Error(
      ErrorCode::kNotFound, picture, "",
      fmt::format("the volume of its job is not there (sought at {}); move it to the picture's folder, or change "
                  "\"volume\" in the job that kiln info {} --json prints",
                  fmt::join(names, " and "), picture.string()));
}

// Parses a job without a folder, so that the names of volumes stay unchanged. Errors name the picture.
RenderJob parsedFrom(const fs::path& picture, const std::string& job) {
  try {
    return parseJob(job, {});
  } catch (const Error& error) {
    if (!error.path().empty()) throw;
    throw Error(error.code(), picture, "", error.what());
  }
}

}  // namespace

std::optional<std::string> jobTextOf(const fs::path& picture, std::uint64_t memory_bytes) {
  const std::map<std::string, std::string> texts = readImageText(picture, memory_bytes);
  const auto text = texts.find(ImageMetadata::kJob);
  return text == texts.end() ? std::nullopt : std::optional(text->second);
}

RenderJob jobOfPicture(const fs::path& picture, std::uint64_t memory_bytes) {
  const std::optional<std::string> text = jobTextOf(picture, memory_bytes);
  if (!text)
    throw Error(ErrorCode::kUsage, picture, "",
                "is a picture without a job of Kiln; name a store, a volume file or a job");
  RenderJob job = parsedFrom(picture, *text);
  forEachVolume(job, [&](const fs::path& volume) { return foundVolume(volume, picture); });
  return job;
}

}  // namespace kiln::tool
