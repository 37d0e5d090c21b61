#include <fmt/format.h>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "ingest/chunks/chunked_source.h"
#include "ingest/source/formats.h"
#include "ingest/zarr/ome_image.h"
#include "ingest/zarr/zarr_chunks.h"
#include "ingest/zarr/zarr_image.h"

namespace kiln {
namespace fs = std::filesystem;

namespace {

// Other programs may use the name attributes.json: its contents show an array, a root or a group of N5.
bool isOfN5(const fs::path& header, std::uint64_t memory_bytes) {
  const JsonNode json(header, memory_bytes);
  if (json.findIn("dimensions") || json.findIn("n5")) return true;
  bool above_others = false;
  forEachEntry(header.parent_path(), [&](const fs::directory_entry& entry) {
    above_others = isThere(entry.path() / header.filename());
    return above_others ? Walk::kStop : Walk::kGoOn;
  });
  return above_others;
}

}  // namespace

bool isZarrFolder(const fs::path& folder, const SourceOptions& options) {
  const fs::path header = zarrHeaderIn(folder);
  if (!header.empty() && (header.filename() != "attributes.json" || isOfN5(header, options.memory_bytes))) return true;
  const std::string ending = lowered(withoutTrailingSlash(folder).extension().string());
  return ending == ".zarr" || ending == ".n5";
}

std::unique_ptr<VolumeSource> openZarr(const fs::path& input, const SourceOptions& options) {
  ZarrImage image = openZarrImage(input, options);
  SourceInfo info;
  info.format = image.array.format;
  info.files = {input};
  info.files.insert(info.files.end(), image.headers.begin(), image.headers.end());
  info.trees = {image.array.folder};
  image.array.attributes.reset();  // the whole header in memory
  return openChunked(std::move(info), image.volume, std::make_unique<ZarrChunks>(std::move(image.array)));
}

std::vector<ListedVolume> listZarr(const fs::path& folder, const SourceOptions& options) {
  const std::optional<OmeImage> image = readOmeImage(folder, options.memory_bytes);
  const std::size_t scales = image ? image->scales() : 1;
  std::vector<ListedVolume> out;
  for (std::size_t scale = 0; scale < scales; ++scale) {
    ListedVolume& volume = out.emplace_back();
    volume.name = scales > 1 ? fmt::format("scale {}", scale) : folder.filename().string();
    volume.kind = "Zarr";
    SourceOptions chosen = options;
    if (scales > 1) chosen.scale = static_cast<std::int64_t>(scale);
    try {
      const ZarrImage opened = openZarrImage(folder, chosen);
      volume.kind = opened.array.format;
      volume.dims = opened.volume.geometry.dims;
      volume.type = opened.array.number.voxelType();
      if (scales > 1) volume.option = fmt::format("--scale {}", scale);
    } catch (const Error& error) {
      volume.refusal = error.what();  // lists channels and times that are to be chosen
    }
  }
  return out;
}

}  // namespace kiln
