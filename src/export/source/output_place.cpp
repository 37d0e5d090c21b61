#include "export/source/output_place.h"

#include <fmt/format.h>

#include <system_error>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// The name without links; as it stands if the disk fails.
fs::path wholeName(const fs::path& path) {
  std::error_code unknown;
  const fs::path whole = fs::weakly_canonical(withoutTrailingSlash(path), unknown);
  return unknown ? path : whole;
}

}  // namespace

ExportInputs::ExportInputs(const StoreReader& store) {
  for (const std::string& file : store.manifest().source.files) {
    const fs::path name = withoutTrailingSlash(file);
    // A relative name was given in the folder of the conversion, which is in most cases the store's.
    for (const fs::path& place : {name, withoutTrailingSlash(store.path()).parent_path() / name})
      if (std::error_code unknown; fs::exists(place, unknown)) sources_.insert(wholeName(place));
  }
}

void ExportInputs::requireNone(const fs::path& out) const {
  requireOutsideStores(out);
  if (sources_.empty() || !isThere(out)) return;
  const fs::path whole = wholeName(out);
  // Names below a folder follow the folder in the order of paths.
  const auto found = sources_.lower_bound(whole);
  if (found == sources_.end() || !isWithin(*found, whole)) return;
  throw Error(ErrorCode::kUsage, out, "",
              fmt::format("{} {}, from which the store was made; name another output", *found == whole ? "is" : "holds",
                          found->string()));
}

void requireAbsent(const fs::path& out, bool overwrite) {
  if (!overwrite && isThere(out))
    throw Error(ErrorCode::kExists, out, "", "is there already; name another output or give --overwrite");
}

void requirePlace(const StoreReader& store, const fs::path& file, bool overwrite, FileSystem& disk) {
  requireAbsent(file, overwrite);
  ExportInputs(store).requireNone(file);
  disk.requirePlaceToRename(file);
}

}  // namespace kiln
