#include "picture_job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/path_status.h"
#include "image/file/image_file.h"
#include "sequence/sequence_frames.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

// Returns the places at which a volume of the picture may be, the likeliest first.
std::vector<fs::path> placesOf(const fs::path& volume, const fs::path& picture) {
  const fs::path folder = picture.parent_path();
  const fs::path named = volume.has_filename() ? volume : volume.parent_path();
  std::vector<fs::path> out{folder / named, folder / named.filename(), named};
  for (auto place = out.begin() + 1; place != out.end();)
    place = std::find(out.begin(), place, *place) != place ? out.erase(place) : place + 1;
  return out;
}

fs::path foundVolume(const fs::path& volume, const fs::path& picture) {
  if (volume.string().starts_with("phantom:")) return volume;
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

}  // namespace

bool isPicture(const fs::path& path) {
  const std::string ending = extensionOf(path);
  return ending == ".exr" || ending == ".png";
}

RenderJob jobOfPicture(const fs::path& picture) {
  const auto texts = readImageText(picture);
  const auto text = texts.find(ImageMetadata::kJob);
  if (text == texts.end())
    throw Error(ErrorCode::kUsage, picture, "",
                "is a picture without a job of Kiln; name a store, a volume file or a job");
  parseJob(text->second, picture);  // errors name the picture
  // Without a folder the names of volumes stay as they are in the job.
  RenderJob job = parseJob(text->second, {});
  forEachVolume(job, [&](const fs::path& volume) { return foundVolume(volume, picture); });
  return job;
}

}  // namespace kiln::tool
