// A folder of files that is filled beside its destination, as OUT.partial, until all files are whole.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/file/file.h"
#include "base/file/file_lock.h"

namespace kiln {

/// The mark of an unfinished export, which no folder of a user has.
inline constexpr const char* kUnfinishedMark = "kiln-export.txt";

/// The treatment of a folder that an interrupted export left.
enum class Leftover { kRefuse, kRemove, kContinue };

/// Returns the treatment that the options --resume and --overwrite choose.
Leftover leftoverFor(bool resume, bool overwrite);

class PendingFolder {
 public:
  /// Makes the folder, or continues one of equal `contents`, a text of one line that describes what is written. Holds
  /// the lock of `out` from here on. A moveOut that was killed is undone or completed before a leftover is removed or
  /// continued, so test names again behind the constructor. throws: Error kExists if another process holds the lock, if
  /// the folder is no export, is refused, or has other contents, or if files of a killed moveOut were moved since;
  /// kNotFound if the folder of `out` does not exist; kIo, kNoSpace.
  PendingFolder(const std::filesystem::path& out, const std::string& contents, Leftover leftover, FileSystem& disk);
  /// Removes the folder, unless it was kept, continued or moved away.
  ~PendingFolder();
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// True if files of an earlier export may be in the folder.
  bool continued() const { return continued_; }
  /// Leaves the folder to a later export.
  void keep() { kept_ = true; }
  /// Brings all files onto the disk and gives the folder the name `out`; a folder of this name is replaced in one step
  /// where the disk can. throws: Error kIo, kNoSpace.
  void publish();
  /// Checks before the work that moveOut(files) can rename: no two files are links to one place, links lead to the disk
  /// of the folder, and each place is free or has a regular file. throws: Error kUsage, kExists, kIo, kNoSpace.
  void requirePlaces(const std::vector<std::filesystem::path>& files) const;
  /// Brings all files onto the disk and moves the files named like `files` to `files`, together: after a failure all
  /// are in the folder again, and replaced files have their names. A link stays, and its target is replaced. Replaced
  /// files go into the folder before the first new file gets its name: after a kill files are missing until the next
  /// export, and an old file never lies beside a new one. Replaced files are removed when all new files have names.
  /// After a failure the destructor removes the folder only if it was not kept. throws: Error kExists if a place has no
  /// regular file; kIo, kNoSpace.
  void moveOut(const std::vector<std::filesystem::path>& files);

 private:
  struct Move {
    std::filesystem::path from, to;
  };

  void recover();
  void sync() { disk_.syncAll(path_); }
  void replaceInSteps();
  void requireRename(const std::filesystem::path& link, const std::filesystem::path& place) const;
  void begin(const std::string& contents, Leftover leftover);

  const std::filesystem::path out_, path_;
  FileSystem& disk_;
  const FileLock lock_;
  bool continued_ = false, kept_ = false;
};

}  // namespace kiln
