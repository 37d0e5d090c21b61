#include "convert/resume/output_directory.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <set>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/file/same_file.h"
#include "convert/resume/journal.h"
#include "ingest/source/header_text.h"
#include "store/manifest/store_files.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;

bool isNothing(const fs::path& path) {
  if (!isNameTaken(path)) return true;
  std::error_code unknown;
  if (!fs::is_directory(path, unknown)) {
    if (unknown && isThere(path)) throw systemError(unknown.value(), path, "looking into the directory");
    return false;
  }
  bool empty = true;
  forEachEntry(path, [&](const fs::directory_entry& entry) {
    empty = entry.path().filename() == kLockInside;
    return empty ? Walk::kGoOn : Walk::kStop;
  });
  return empty;
}

namespace {

bool isUnfinished(const fs::path& directory) { return !isStore(directory) && isThere(Journal::pathIn(directory)); }

bool isNameInStore(const fs::path& name) {
  for (const fs::path& known : {fs::path(kManifestFile), fs::path(kIndexFile), fs::path("bricks"), fs::path("parts"),
                                Journal::pathIn({}).filename(), fs::path(kLockInside)})
    if (name == known || name == known.string() + ".tmp") return true;
  return name.string().starts_with("scratch_") && name.extension() == ".tmp";
}

// Files that desktops leave in every folder shown, without value to a user.
bool isDroppedByDesktop(const fs::path& name) {
  static const std::set<std::string> kNames = {".DS_Store", ".directory", ".localized", "Thumbs.db", "desktop.ini"};
  return kNames.contains(name.string()) || name.string().starts_with("._");
}

// True for the names, from the store's folder on, of bricks and of the halves that a conversion sets aside.
bool isNameBelowStore(const std::string& name) {
  static const std::regex kBrick(R"(bricks/\d+/\d+_\d+_\d+\.vdb(\.tmp)?)"),
      kHalf(R"(parts/(\d+/)?\d+_\d+_\d+_\d+\.tmp)");
  return std::regex_match(name, kBrick) || std::regex_match(name, kHalf);
}

// Returns the names in a directory that do not belong to a store, in alphabetical order, with their folders below.
std::vector<std::string> strangersIn(const fs::path& directory) {
  std::vector<std::string> out;
  forEachEntryBelow(directory, [&](const fs::directory_entry& entry) {
    const fs::path name = entry.path().filename();
    const std::string from_store = entry.path().lexically_relative(directory).string();
    std::error_code unknown;
    const bool below = entry.path().parent_path() != directory;
    const bool known = below ? entry.is_directory(unknown) || isNameBelowStore(from_store) : isNameInStore(name);
    if (!known && !isDroppedByDesktop(name)) out.push_back(from_store);
    return Walk::kGoOn;
  });
  std::sort(out.begin(), out.end());
  return out;
}

// True for a directory with only the contents of a store, finished or not: safe to replace or resume.
bool holdsOnlyAStore(const fs::path& directory) {
  std::error_code error;
  return fs::is_directory(directory, error) && strangersIn(directory).empty();
}

// True for the rest of a replaced store left by an interrupted --overwrite, whose manifest is removed first. With a
// manifest it may be a user's store.
bool mayBeRemoved(const fs::path& old) {
  return isNothing(old) || (holdsOnlyAStore(old) && !isStore(old) && !isUnfinished(old));
}

// Resolves links, "." and "..", because the ".partial" and ".old" names are formed from the result.
fs::path placeOf(const fs::path& out) {
  const fs::path named = withoutTrailingSlash(out);
  std::error_code unknown;
  if (named.filename() == "." || named.filename() == "..")
    if (fs::path whole = fs::canonical(named, unknown); !unknown) return whole;
  return withoutTrailingSlash(behindLinks(named));
}

}  // namespace

OutputDirectory::OutputDirectory(const fs::path& out, bool overwrite, bool resume, FileSystem& disk,
                                 const FileLock* locked)
    : out_(placeOf(out)), building_(out_), disk_(disk), lock_(locked) {
  requireOutsideStores(out_);
  if (lock_ == nullptr) {
    if (out_.has_parent_path()) disk_.makeDirectories(out_.parent_path());
    lock_ = &own_lock_.emplace(lockOf(out_), refusalOf(out_));
  }
  choosePlace(overwrite, resume);
  std::error_code ignored;
  if (!fs::is_directory(building_, ignored)) return;
  if (isNothing(building_))
    requireOwnDirectory(building_);
  else if (!finished_)
    requireOwner(building_);
}

void OutputDirectory::choosePlace(bool overwrite, bool resume) {
  const fs::path partial = out_.string() + ".partial";
  if (resume && holdsOnlyAStore(partial) && (isUnfinished(partial) || isStore(partial))) {
    building_ = partial;
    finished_ = isStore(partial);
    requirePlaceForOld();
    return;
  }
  if (isNothing(out_)) return;
  if (!overwrite && !resume) {
    throw Error(ErrorCode::kExists, out_, "",
                isUnfinished(out_) ? "holds an unfinished conversion; continue it by --resume, or give --overwrite"
                                   : "is there already; name another output or give --overwrite");
  }
  if (!holdsOnlyAStore(out_)) {
    const std::vector<std::string> strangers =
        isStore(out_) || isUnfinished(out_) ? strangersIn(out_) : std::vector<std::string>();
    throw Error(ErrorCode::kExists, out_, "",
                strangers.empty()
                    ? "is not a store, so it is neither replaced nor resumed; name another output"
                    : fmt::format("holds {}{} beside the store, so it is not replaced; move {} away, or name another "
                                  "output",
                                  inQuotes(strangers.front()),
                                  strangers.size() == 1 ? "" : fmt::format(" and {} more", strangers.size() - 1),
                                  strangers.size() == 1 ? "this file" : "these files"));
  }
  if (resume && isUnfinished(out_)) return;
  if (!overwrite) {
    finished_ = isStore(out_);
    return;
  }
  building_ = partial;
  requirePlaceForOld();
  if (isNothing(partial)) return;
  if (!holdsOnlyAStore(partial))
    throw Error(ErrorCode::kExists, partial, "", "is in the way and is not an unfinished store; move it");
  disk_.removeAll(partial);
}

fs::path OutputDirectory::old() const { return out_.string() + ".old"; }

void OutputDirectory::requirePlaceForOld() const {
  if (isNothing(out_) || mayBeRemoved(old())) return;
  throw Error(ErrorCode::kExists, old(), "",
              "is in the way of replacing the store: a kept store, or the old or the new store of an interrupted "
              "--overwrite; compare both with kiln info, then move or remove this one");
}

void OutputDirectory::clear() {
  std::error_code ignored;
  if (fs::exists(building_, ignored)) disk_.removeAll(building_);
}

void OutputDirectory::make() {
  disk_.makeDirectories(building_);
  requireOwner(building_);
}

// Restores the names of both stores after a failed exchange, as far as the file system allows.
void OutputDirectory::restoreNames(bool exchanged) const noexcept {
  try {
    if (exchanged && !FileSystem::real().exchange(old(), out_)) return;
  } catch (const Error&) {
    return;  // the caller reports the first error
  }
  std::error_code ignored;
  fs::rename(old(), building_, ignored);
}

// Exchanges the new store with the old store, so that a reader always finds a store. Returns false, with nothing
// changed, if the file system cannot exchange names. A crash between both calls leaves the old store in place.
bool OutputDirectory::exchange() {
  bool exchanged = false;
  try {
    disk_.rename(building_, old());
    exchanged = disk_.exchange(old(), out_);
    if (exchanged) disk_.syncAll(out_);
  } catch (...) {
    restoreNames(exchanged);
    throw;
  }
  if (exchanged) return true;
  try {
    disk_.rename(old(), building_);
  } catch (const Error& error) {
    throw Error(
        error.code(), old(), "",
        fmt::format("holds the finished store, which could not be renamed ({}); rename it to {} and continue by "
                    "--resume",
                    error.what(), building_.string()));
  }
  return false;
}

void OutputDirectory::commit() {
  if (building_ == out_) return tidy();
  requirePlaceForOld();
  const bool replaces = !isNothing(out_);
  if (!replaces && isStore(old()))
    left_old_ = old().string() + " is left: a kept store, or the old store of an interrupted --overwrite";
  if (replaces) disk_.removeAll(old());
  if (!replaces || !exchange()) disk_.renameInSteps(building_, out_, replaces ? old() : fs::path());
  try {
    if (replaces) removeOld();
  } catch (const Error& error) {
    // The new store is in place; the next --overwrite removes the rest of the old store.
    left_old_ = fmt::format("{} is left of the store that was replaced ({}); remove it", old().string(), error.what());
  }
  tidy();
}

// Keeps files of the user that came into the old store while the new store was made.
void OutputDirectory::removeOld() {
  const std::vector<std::string> strangers = strangersIn(old());
  if (strangers.empty()) {
    disk_.removeAll(old() / kManifestFile);
    disk_.removeAll(old());
  } else {
    left_old_ = fmt::format(
        "{} is left of the store that was replaced, because {} came into it meanwhile; move this file away, then "
        "remove the folder",
        old().string(), inQuotes(strangers.front()));
  }
}

void OutputDirectory::tidy() noexcept {
  std::error_code ignored;
  fs::remove(Journal::pathIn(out_), ignored);
  fs::remove_all(out_ / "parts", ignored);
}

void OutputDirectory::keepForResuming() noexcept {
  std::error_code ignored;
  fs::remove(building_ / kManifestFile, ignored);
}

void OutputDirectory::abandon() noexcept {
  std::error_code ignored;
  fs::remove_all(building_, ignored);
}

}  // namespace kiln
