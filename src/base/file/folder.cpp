#include "base/file/folder.h"

#include <algorithm>

#include "base/error.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Returns false if a visit stopped the walk.
bool walk(const fs::path& folder, bool below, const VisitEntry& visit) {
  std::error_code error;
  fs::directory_iterator at;
  do {
    at = fs::directory_iterator(folder, error);
  } while (error == std::errc::interrupted);
  for (; !error && at != fs::directory_iterator(); at.increment(error)) {
    const Walk next = visit(*at);
    if (next == Walk::kStop) return false;
    if (!below || next == Walk::kPassOver) continue;
    std::error_code unknown;
    if (at->is_symlink(unknown) || !at->is_directory(unknown)) continue;
    if (!walk(at->path(), true, visit)) return false;
  }
  if (error) throw systemError(error.value(), folder, "listing the directory");
  return true;
}

}  // namespace

void forEachEntry(const fs::path& folder, const VisitEntry& visit) { walk(folder, false, visit); }

void forEachEntryBelow(const fs::path& folder, const VisitEntry& visit) { walk(folder, true, visit); }

bool isWithin(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

}  // namespace kiln
