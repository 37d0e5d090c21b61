#include "bench/suite_stores.h"

#include <chrono>

#include "base/file/file.h"
#include "base/hash.h"
#include "convert/foreign_cache.h"
#include "convert/store_of_source.h"
#include "ingest/open_source.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Returns "cthead-1f0c33aa.kiln": a readable name, and a hash because files in different folders may have equal names.
fs::path storeName(const std::string& volume, SuiteLevels levels) {
  std::string stem = fs::path(volume).stem().string();
  for (char& c : stem)
    if (c == ':' || c == '/') c = '-';
  return stem + "-" + toHex(hashOf(std::string_view(volume))).substr(0, 8) +
         (levels == SuiteLevels::kAll ? "-levels.kiln" : ".kiln");
}

}  // namespace

SuiteStore suiteStore(const std::string& volume, SuiteLevels levels, const fs::path& stores, const std::string& command,
                      const std::string& time, Progress& progress) {
  if (isStore(volume)) return {volume, 0};
  const std::unique_ptr<VolumeSource> source = openSource(volume);
  const fs::path store = stores / storeName(volume, levels);
  if (isStoreOf(store, source->info())) return {store, 0};
  FileSystem::real().makeDirectories(stores);
  ConvertOptions options;
  options.overwrite = true;
  if (levels == SuiteLevels::kFinest) options.most_levels = 1;
  options.command = command;
  options.time = time;
  const auto begin = std::chrono::steady_clock::now();
  convert(*source, store, options, progress);
  return {store, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()};
}

}  // namespace kiln
