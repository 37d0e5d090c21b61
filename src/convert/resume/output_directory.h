// Where a conversion builds its store, what of an earlier one it may replace or go on with, and how the new store comes
// to stand at its name in one step.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/file.h"
#include "base/file_lock.h"

namespace kiln {

/// Whether a store may be built there without anything being lost: nothing has the name, or an empty directory.
bool isNothing(const std::filesystem::path& path);

class OutputDirectory {
 public:
  /// A new store at `out`; with `overwrite` in place of one that is there, which stays until the new one is whole; with
  /// `resume` what an interrupted conversion left is gone on with; with both, resumed where there is something to
  /// resume and replaced where not. throws: Error kExists where what is there is neither to be replaced nor resumed,
  /// or OUT.old, a name that replacing needs, is somebody's; kUsage where `out` is in another store; kIo where others
  /// could change what is made there. From here on no other process makes a store at `out`: a lock is held (lockOf),
  /// unless `locked` is the caller's, and where another process holds it Error kExists is thrown.
  OutputDirectory(const std::filesystem::path& out, bool overwrite, bool resume, FileSystem& disk,
                  const FileLock* locked = nullptr);

  /// The lock on `out`.
  const FileLock& lock() const { return *lock_; }

  /// The directory in which the store is built: `out`, or a name beside it.
  const std::filesystem::path& building() const { return building_; }
  /// True where an earlier conversion wrote the last byte, and at most the name is left to change.
  bool finished() const { return finished_; }
  /// Removes what an earlier conversion left. requires: not finished().
  void clear();
  /// Makes the directory, if it is not there. throws: Error kIo, also where it is another user's.
  void make();
  /// The built store loses what only a resumed conversion needs, and takes its name. throws: Error kIo; what was at
  /// `out` is then still there.
  void commit();
  /// After it, a sentence on the store that was replaced, where that is left; else empty.
  const std::string& leftOld() const { return left_old_; }
  /// What was built stays, and is no store.
  void keepForResuming() noexcept;
  /// Removes what was built.
  void abandon() noexcept;

 private:
  void tidy() noexcept;
  bool exchange();
  void restoreNames(bool exchanged) const noexcept;
  void replaceInSteps(bool replaces);
  // Where the store that is replaced waits until the new one has its name.
  std::filesystem::path old() const;
  void requirePlaceForOld() const;
  void choosePlace(bool overwrite, bool resume);
  const std::filesystem::path out_;
  std::filesystem::path building_;
  std::string left_old_;
  FileSystem& disk_;
  std::optional<FileLock> own_lock_;
  const FileLock* lock_;
  bool finished_ = false;
};

}  // namespace kiln
