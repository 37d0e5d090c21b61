#include "convert/store_of_source.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "convert/resume/source_state.h"
#include "ingest/source/formats.h"
#include "store/manifest/store_files.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

bool sameVolume(const Manifest& manifest, const SourceInfo& info) {
  const bool same_grid = manifest.source.vdb.has_value() == info.vdb.has_value() &&
                         (!info.vdb || manifest.source.vdb->grid_name == info.vdb->grid_name);
  const VolumeGeometry& stored = manifest.geometry();
  return same_grid && manifest.source.format == info.format && manifest.type == info.type &&
         stored.dims == info.geometry.dims && stored.world_from_index == info.geometry.world_from_index &&
         stored.frame == info.geometry.frame && stored.unit == info.geometry.unit;
}

bool isYounger(const fs::path& store, const std::vector<fs::path>& files) {
  std::error_code error;
  const auto finished = fs::last_write_time(store / kManifestFile, error);
  return !error && std::all_of(files.begin(), files.end(), [&](const fs::path& file) {
    return namesPhantom(file) || (fs::last_write_time(file, error) <= finished && !error);
  });
}

}  // namespace

bool isStoreOf(const fs::path& store, const SourceInfo& info, std::uint64_t memory_bytes) {
  try {
    const Manifest manifest = StoreReader(store, memory_bytes).manifest();
    return (manifest.source.state.empty() ? isYounger(store, info.files)
                                          : isStateOf(manifest.source.state, info.files, info.trees)) &&
           sameVolume(manifest, info);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kBudget) throw;
    return false;  // damaged, or of another format: will be made anew
  }
}

}  // namespace kiln
