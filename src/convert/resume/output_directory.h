// The output directory of a conversion: decides if an existing directory may be replaced or resumed, builds the store,
// and publishes the store under the final name in a single step.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/file/file.h"
#include "base/file/file_lock.h"

namespace kiln {

/// True if a store can be built without loss: the name is free, or is an empty directory.
bool isNothing(const std::filesystem::path& path);

class OutputDirectory {
 public:
  /// Opens the output for a new store at `out`.
  /// - `overwrite`: replaces an existing store, which stays until the new store is whole.
  /// - `resume`: continues an interrupted conversion.
  /// - both: resumes if possible, else replaces.
  /// Holds a lock (lockOf) from here on, unless the caller passes its own as `locked`: no other process can make a
  /// store at `out`.
  /// throws: Error kExists if existing files may neither be replaced nor resumed, if OUT.old, a name needed for
  /// replacing, belongs to the user, or if another process holds the lock; kUsage if `out` is inside another
  /// store; kIo if other users could change the new files.
  OutputDirectory(const std::filesystem::path& out, bool overwrite, bool resume, FileSystem& disk,
                  const FileLock* locked = nullptr);

  /// The lock on `out`.
  const FileLock& lock() const { return *lock_; }

  /// The directory of the unfinished store: `out`, or a name beside `out`.
  const std::filesystem::path& building() const { return building_; }
  /// True if an earlier conversion wrote the last byte, and at most the renaming is left.
  bool finished() const { return finished_; }
  /// Removes the files of an earlier conversion. requires: not finished().
  void clear();
  /// Makes the directory if needed. throws: Error kIo, also if the directory belongs to another user.
  void make();
  /// Removes the files needed for resuming only, and gives the store its name. throws: Error kIo; the old contents of
  /// `out` are then still there.
  void commit();
  /// After `commit`, a sentence about a replaced store that could not be removed; else empty.
  const std::string& leftOld() const { return left_old_; }
  /// Keeps the built files, without a manifest.
  void keepForResuming() noexcept;
  /// Removes the built files.
  void abandon() noexcept;

 private:
  void removeOld();
  void tidy() noexcept;
  bool exchange();
  void restoreNames(bool exchanged) const noexcept;
  // Name of the replaced store while the new store takes the name `out`.
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
