#include "picture_job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "image/file/image_file.h"
#include "job/job_facts.h"
#include "job/job_names.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

// Returns the places at which a volume of the picture may be, the likeliest first. `drawn_from` is the folder of the
// command that drew the picture, as seen from the picture's folder; empty if unknown.
std::vector<fs::path> placesOf(const fs::path& volume, const fs::path& picture, const fs::path& drawn_from) {
  const fs::path folder = picture.parent_path();
  const fs::path named = withoutTrailingSlash(volume);
  std::vector<fs::path> out{folder / drawn_from / named, folder / named, folder / named.filename(), named};
  for (auto place = out.begin() + 1; place != out.end();)
    place = std::find(out.begin(), place, *place) != place ? out.erase(place) : place + 1;
  return out;
}

// Returns "a" for "out/../a", unless `out` is a link to a folder with another parent.
fs::path spelledShortly(const fs::path& there) {
  std::error_code unknown;
  fs::path out = there.lexically_normal();
  return fs::equivalent(there, out, unknown) ? out : there;
}

fs::path foundVolume(const fs::path& volume, const fs::path& picture, const fs::path& drawn_from) {
  const std::vector<fs::path> places = placesOf(volume, picture, drawn_from);
  const auto found = std::find_if(places.begin(), places.end(), [](const fs::path& place) { return isThere(place); });
  if (found != places.end()) return spelledShortly(*found);
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

// Returns the type of the colours, else of the first channel.
std::string exrTypeOf(const PixelLayout& layout) {
  for (const auto& [name, type] : layout.channels) {
    if (name == "R") return type;
  }
  return layout.channels.empty() ? "" : layout.channels.front().second;
}

// Adds the file's pixel type and compression to the job, so that the job draws an equal file.
void addLayout(const PixelLayout& layout, nlohmann::ordered_json& job) {
  if (layout.png_bits > 0) {
    if (layout.png_bits == 16) job["png"] = {{"bits", 16}};
    return;
  }
  nlohmann::ordered_json& exr = job["exr"];
  if (!exr.is_object()) exr = nlohmann::ordered_json::object();
  if (const std::string type = exrTypeOf(layout); type == "half" || type == "float") exr["type"] = type;
  if (std::ranges::find(kExrCompressionNames, layout.compression) != kExrCompressionNames.end())
    exr["compression"] = layout.compression;
}

std::optional<std::string> jobTextIn(const std::map<std::string, std::string>& texts, const fs::path& picture) {
  const auto text = texts.find(ImageMetadata::kJob);
  if (text == texts.end()) return std::nullopt;
  auto job = nlohmann::ordered_json::parse(text->second, nullptr, /*allow_exceptions=*/false);
  if (!job.is_object()) return text->second;
  addLayout(readPixelLayout(picture), job);
  return job.dump(2);
}

}  // namespace

std::optional<std::string> jobTextOf(const fs::path& picture, std::uint64_t memory_bytes) {
  return jobTextIn(readImageText(picture, memory_bytes), picture);
}

RenderJob jobOfPicture(const fs::path& picture, std::uint64_t memory_bytes) {
  const std::map<std::string, std::string> texts = readImageText(picture, memory_bytes);
  const std::optional<std::string> text = jobTextIn(texts, picture);
  if (!text)
    throw Error(ErrorCode::kUsage, picture, "",
                "is a picture without a job of Kiln; name a store, a volume file or a job");
  RenderJob job = parsedFrom(picture, *text);
  const auto folder = texts.find(ImageMetadata::kFolder);
  const fs::path drawn_from = folder == texts.end() ? fs::path() : fs::path(folder->second);
  forEachVolume(job, [&](const fs::path& volume) { return foundVolume(volume, picture, drawn_from); });
  return job;
}

}  // namespace kiln::tool
