#include "base/text.h"
#include "ingest/chunks/chunked_source.h"
#include "ingest/source/formats.h"
#include "ingest/zarr/zarr_chunks.h"
#include "ingest/zarr/zarr_image.h"

namespace kiln {
namespace fs = std::filesystem;

bool isZarrFolder(const fs::path& folder) {
  if (!zarrHeaderIn(folder).empty()) return true;
  const std::string ending =
      lowered(folder.has_filename() ? folder.extension().string() : folder.parent_path().extension().string());
  return ending == ".zarr" || ending == ".n5";
}

std::unique_ptr<VolumeSource> openZarr(const fs::path& input, const SourceOptions& options) {
  ZarrImage image = openZarrImage(input, options);
  SourceInfo info;
  info.format = image.array.format;
  info.files = {input};
  info.files.insert(info.files.end(), image.headers.begin(), image.headers.end());
  info.trees = {image.array.folder};
  return openChunked(std::move(info), image.volume, std::make_unique<ZarrChunks>(std::move(image.array)));
}

}  // namespace kiln
