#include "export/output/pending_folder.h"

#include <system_error>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// True if a process was killed before it wrote the mark.
bool isBarelyBegun(const fs::path& folder) {
  bool out = true;
  forEachEntry(folder, [&](const fs::directory_entry& entry) {
    out = entry.path().filename().string().starts_with(kUnfinishedMark);
    return out ? Walk::kGoOn : Walk::kStop;
  });
  return out;
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
  begin(contents, leftover);
}

void PendingFolder::begin(const std::string& contents, Leftover leftover) {
  const fs::path description = path_ / kUnfinishedMark;
  if (isNameTaken(path_) && !(isFolder(path_) && isBarelyBegun(path_))) {
    if (!isFolder(path_) || !isThere(description))
      throw Error(ErrorCode::kExists, path_, "", "is in the way and is no unfinished export; move it");
    continued_ = kept_ = leftover == Leftover::kContinue && readTextFile(description) == contents;
    if (continued_) return;
    if (leftover == Leftover::kContinue)
      throw Error(ErrorCode::kExists, path_, "",
                  "is an unfinished export of another store, level or region, or with other options; give --overwrite "
                  "without --resume "
                  "to begin anew");
    if (leftover == Leftover::kRefuse)
      throw Error(ErrorCode::kExists, path_, "",
                  "is an unfinished export; continue it by --resume, or give --overwrite to begin anew");
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

PendingFolder::~PendingFolder() {
  std::error_code ignored;
  if (!kept_) fs::remove_all(path_, ignored);
}

void PendingFolder::moveOut(const std::vector<fs::path>& files) {
  sync();
  // Names are exchanged, so that a failure can exchange them back: the folder holds the replaced files until its end.
  struct Move {
    fs::path own, place;
  };
  std::vector<Move> moved, replaced;
  try {
    for (const fs::path& file : files) {
      const Move move{path_ / file.filename(), behindLinks(file)};
      if (!isNameTaken(move.place)) {
        disk_.rename(move.own, move.place);
        moved.push_back(move);
      } else {
        exchangeNames(move.own, move.place);
        replaced.push_back(move);
      }
    }
  } catch (...) {
    std::error_code ignored;
    for (const auto& [own, place] : moved) fs::rename(place, own, ignored);
    for (const auto& [own, place] : replaced) {
      try {
        exchangeNames(own, place);
      } catch (const Error&) {
        kept_ = true;  // the older file is in the folder
      }
    }
    throw;
  }
  kept_ = false;
}

// In steps where the disk cannot exchange two names.
void PendingFolder::exchangeNames(const fs::path& own, const fs::path& file) {
  if (disk_.exchange(own, file)) return;
  const fs::path old = own.string() + ".old";
  disk_.rename(file, old);
  try {
    disk_.rename(own, file);
    disk_.rename(old, own);
  } catch (...) {
    std::error_code ignored;
    if (!isThere(own)) fs::rename(file, own, ignored);
    fs::rename(old, file, ignored);
    throw;
  }
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
