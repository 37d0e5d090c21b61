#include "bench/suite_stores.h"

#include <chrono>
#include <system_error>

#include "base/hash.h"
#include "convert/convert.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// "cthead-1f0c33aa.kiln": the name for people, the hash because two folders may hold files of one name.
fs::path storeName(const std::string& volume) {
  std::string stem = fs::path(volume).stem().string();
  for (char& c : stem)
    if (c == ':' || c == '/') c = '-';
  return stem + "-" + toHex(hashOf(std::string_view(volume))).substr(0, 8) + ".kiln";
}

// A store is up to date if it was finished after its source was last written, and has its voxels' shape and type.
bool upToDate(const fs::path& store, const SourceInfo& info) {
  std::error_code error;
  const auto finished = fs::last_write_time(store / "manifest.json", error);
  if (error) return false;
  for (const fs::path& file : info.files) {
    const auto written = fs::last_write_time(file, error);
    if (!error && written > finished) return false;  // a phantom has no file
  }
  try {
    const StoreReader reader(store);
    return reader.manifest().type == info.type && reader.manifest().geometry().dims == info.geometry.dims &&
           reader.manifest().geometry().world_from_index == info.geometry.world_from_index;
  } catch (const Error&) {
    return false;  // damaged, or of another format: made anew
  }
}

}  // namespace

SuiteStore suiteStore(const std::string& volume, const fs::path& stores, const std::string& command,
                      const std::string& time, Progress& progress) {
  if (isStore(volume)) return {volume, 0};
  const std::unique_ptr<VolumeSource> source = openSource(volume);
  const fs::path store = stores / storeName(volume);
  if (upToDate(store, source->info())) return {store, 0};
  FileSystem::real().makeDirectories(stores);
  ConvertOptions options;
  options.overwrite = true;
  options.command = command;
  options.time = time;
  const auto begin = std::chrono::steady_clock::now();
  convert(*source, store, options, progress);
  return {store, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()};
}

}  // namespace kiln
