#include "export/output/pending_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/file/temporary_file.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// The subfolder of the files that the export replaces.
constexpr const char* kReplacedFiles = "replaced";
// The names that moveOut moves, each with a NUL behind it.
constexpr const char* kMovedNames = "kiln-moves.txt";

// True if a process was killed before it wrote the mark.
bool isBarelyBegun(const fs::path& folder) {
  bool out = true;
  forEachEntry(folder, [&](const fs::directory_entry& entry) {
    out = entry.path().filename().string().starts_with(kUnfinishedMark);
    return out ? Walk::kGoOn : Walk::kStop;
  });
  return out;
}

std::vector<fs::path> movedNames(const fs::path& list) {
  std::vector<fs::path> out;
  if (!isThere(list)) return out;
  const std::string text = readTextFile(list);
  for (std::size_t at = 0, end; (end = text.find('\0', at)) != std::string::npos; at = end + 1)
    out.push_back(fs::path(text.substr(at, end - at)).filename());
  return out;
}

std::vector<fs::path> namesIn(const fs::path& folder) {
  std::vector<fs::path> out;
  if (!isFolder(folder)) return out;
  forEachEntry(folder, [&](const fs::directory_entry& entry) {
    out.push_back(entry.path().filename());
    return Walk::kGoOn;
  });
  return out;
}

// A folder of this name is the user's, and a device has no contents that could be kept.
void requireReplaceable(const fs::path& file, const fs::path& place) {
  if (isNameTaken(place) && !fs::is_regular_file(place))
    throw Error(ErrorCode::kExists, file, "",
                fmt::format("an export replaces only files (found {}); move it, or name another output",
                            isFolder(place) ? "a directory" : "a device, a pipe or a socket"));
}

}  // namespace

Leftover leftoverFor(bool resume, bool overwrite) {
  if (resume) return Leftover::kContinue;
  return overwrite ? Leftover::kRemove : Leftover::kRefuse;
}

PendingFolder::PendingFolder(const fs::path& out, const std::string& contents, Leftover leftover, FileSystem& disk)
    : out_(behindLinks(withoutTrailingSlash(out))),
      path_(out_.string() + ".partial"),
      disk_(disk),
      lock_(lockOf(out_), refusalOf(out_)) {
  requireFolderOf(out_, out);
  begin(contents, leftover);
}

void PendingFolder::begin(const std::string& contents, Leftover leftover) {
  const fs::path description = path_ / kUnfinishedMark;
  if (isNameTaken(path_) && !(isFolder(path_) && isBarelyBegun(path_))) {
    if (!isFolder(path_) || !isThere(description))
      throw Error(ErrorCode::kExists, path_, "", "is in the way and is no unfinished export; move it");
    continued_ = kept_ = leftover == Leftover::kContinue && readTextFile(description) == contents;
    if (continued_) return recover();
    if (leftover == Leftover::kContinue)
      throw Error(ErrorCode::kExists, path_, "",
                  "is an unfinished export of another store, level or region, or with other options; give --overwrite "
                  "without --resume "
                  "to begin anew");
    if (leftover == Leftover::kRefuse)
      throw Error(ErrorCode::kExists, path_, "",
                  "is an unfinished export; continue it by --resume, or give --overwrite to begin anew");
    recover();
    disk_.removeAll(path_);
  }
  try {
    disk_.makeDirectories(path_);
    disk_.writeOwn(description, contents);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    throw;
  }
}

// A kill before the first new file got its name is undone: the older files are whole, and the new files may be of an
// export that is no longer wanted. A later kill is completed, because older files would lie beside new ones.
void PendingFolder::recover() {
  const fs::path old = path_ / kReplacedFiles;
  const std::vector<fs::path> replaced = namesIn(old), moved = movedNames(path_ / kMovedNames);
  if (replaced.empty()) return;
  const bool begun =
      std::any_of(moved.begin(), moved.end(), [&](const fs::path& name) { return !isNameTaken(path_ / name); });
  std::vector<Move> moves;
  for (const fs::path& name : begun ? moved : replaced) {
    const Move move = {(begun ? path_ : old) / name, behindLinks(path_.parent_path() / name)};
    const bool waits = isNameTaken(move.from);
    if (waits == isNameTaken(move.to))
      throw Error(ErrorCode::kExists, old, "",
                  fmt::format("holds the older files of an interrupted export, whose files were moved since (found {} "
                              "{}); move the older files to their names or elsewhere",
                              waits ? "another" : "no", move.to.string()));
    if (waits) moves.push_back(move);
  }
  for (const Move& move : moves) disk_.rename(move.from, move.to);
  disk_.syncAll(path_);
  disk_.removeAll(old);
}

PendingFolder::~PendingFolder() {
  std::error_code ignored;
  if (!kept_) fs::remove_all(path_, ignored);
}

void PendingFolder::requirePlaces(const std::vector<fs::path>& files) const {
  FileNames places;
  for (const fs::path& file : files) {
    if (!places.add(file))
      throw Error(
          ErrorCode::kUsage, file, "",
          fmt::format("leads to {}, as another file of this export does; remove the link", behindLinks(file).string()));
    const fs::path place = behindLinks(file);
    requireReplaceable(file, place);
    if (place != file) requireRename(file, place);
  }
}

// Renames an empty file, because no number of a device or of a mount tells of every border between disks.
void PendingFolder::requireRename(const fs::path& link, const fs::path& place) const {
  const TemporaryFile beside(place);
  const fs::path trial = path_ / (std::string(kUnfinishedMark) + ".trial");
  std::error_code failed, ignored;
  fs::rename(beside.path(), trial, failed);
  fs::remove(trial, ignored);
  if (failed == std::errc::cross_device_link)
    throw Error(ErrorCode::kUsage, link, "",
                fmt::format("leads to {}, which is on another disk than the folder of the link; remove the link, or "
                            "name an output on that disk",
                            place.string()));
  if (failed) throw systemError(failed.value(), place, "renaming into place");
}

void PendingFolder::moveOut(const std::vector<fs::path>& files) {
  std::string names;
  for (const fs::path& file : files) names += file.filename().string() + '\0';
  disk_.writeFile(path_ / kMovedNames, bytesOf(names), WritePolicy::kUnsynced);
  sync();
  std::vector<Move> replaced, finished, done;
  const fs::path old = path_ / kReplacedFiles;
  for (const fs::path& file : files) {
    const fs::path place = behindLinks(file);
    requireReplaceable(file, place);  // again: the work may have taken hours
    if (isNameTaken(place)) replaced.push_back({place, old / file.filename()});
    finished.push_back({path_ / file.filename(), place});
  }
  try {
    if (!replaced.empty()) disk_.makeDirectories(old);
    for (const std::vector<Move>& moves : {replaced, finished})
      for (const Move& move : moves) {
        disk_.rename(move.from, move.to);
        done.push_back(move);
      }
  } catch (...) {
    for (auto move = done.rbegin(); move != done.rend(); ++move) {
      std::error_code failed;
      fs::rename(move->to, move->from, failed);
      if (failed) kept_ = true;  // an older file may be in the folder
    }
    throw;
  }
  kept_ = false;
  std::error_code ignored;
  fs::remove_all(old, ignored);  // before the list of names, which recover() needs
}

// After an exchange the destructor removes the old folder.
void PendingFolder::publish() {
  sync();
  if (!isNameTaken(out_)) {
    disk_.rename(path_, out_);
  } else if (disk_.exchange(path_, out_)) {
    kept_ = false;
  } else {
    replaceInSteps();
  }
  std::error_code ignored;
  fs::remove(out_ / kUnfinishedMark, ignored);
}

// A failure leaves the old folder, under its name where the disk allows.
void PendingFolder::replaceInSteps() {
  const fs::path old = out_.string() + ".old";
  if (isNameTaken(old))
    throw Error(ErrorCode::kExists, old, "",
                "has the name for the folder that is replaced; remove it or give it another name");
  disk_.renameInSteps(path_, out_, old);
  disk_.removeAll(old);
}

}  // namespace kiln
