#include "convert/foreign_cache.h"

#include <system_error>

#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// A store is up to date if it was finished after each of its source's files was last written.
bool upToDate(const fs::path& store, const SourceInfo& info) {
  std::error_code error;
  const auto finished = fs::last_write_time(store / "manifest.json", error);
  if (error) return false;
  for (const fs::path& file : info.files) {
    const auto written = fs::last_write_time(file, error);
    if (error || written > finished) return false;
  }
  return true;
}

}  // namespace

fs::path storeFor(const fs::path& input, const SourceOptions& source_options, const ConvertOptions& options, Progress& progress) {
  std::error_code ignored;
  if (isStore(input) || !fs::exists(input, ignored) || (fs::is_directory(input, ignored) && input.extension() == ".kiln")) return input;
  const std::unique_ptr<VolumeSource> source = openSource(input, source_options);
  const fs::path store = input.string() + ".kiln";
  if (upToDate(store, source->info())) {
    progress.note("using the store " + store.string() + " made from it before");
    return store;
  }
  progress.note("converting to the store " + store.string() + " first");
  ConvertOptions replacing = options;
  replacing.overwrite = true;
  convert(*source, store, replacing, progress);
  return store;
}

}  // namespace kiln
