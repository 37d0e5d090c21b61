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

std::optional<std::string> folderSeenFrom(const fs::path& file, const fs::path& folder) {
  std::error_code unknown;
  const auto whole = [&](const fs::path& path) { return fs::weakly_canonical(fs::absolute(path, unknown), unknown); };
  const fs::path to = whole(folder), from = whole(fs::absolute(file, unknown).parent_path());
  const fs::path way = to.lexically_relative(from);  // empty where a path is unreadable
  const auto topOf = [](const fs::path& path) { return *path.relative_path().begin(); };
  const bool climbs = std::all_of(way.begin(), way.end(), [](const fs::path& step) { return step == ".."; });
  const bool share = to.has_relative_path() && from.has_relative_path() && topOf(to) == topOf(from);
  if (way.empty() || way == "." || !(climbs || share)) return std::nullopt;
  return way.string();
}

}  // namespace kiln
