// Where a conversion builds its store, what of an earlier one it may replace or go on with, and how the new store comes
// to stand at its name in one step.
#pragma once

#include <filesystem>

#include "base/file.h"

namespace kiln {

/// Whether a store may be built there without anything being lost: nothing has the name, or an empty directory.
bool isNothing(const std::filesystem::path& path);

class Destination {
 public:
  /// A new store at `out`; with `overwrite` in place of one that is there, which stays until the new one is whole; with
  /// `resume` what an interrupted conversion left is gone on with; with both, resumed where there is something to
  /// resume and replaced where not. throws: Error kExists where what is there is neither to be replaced nor resumed,
  /// or OUT.old, a name that replacing needs, is somebody's; kIo.
  Destination(const std::filesystem::path& out, bool overwrite, bool resume, FileSystem& disk);

  /// The directory in which the store is built: `out`, or a name beside it.
  const std::filesystem::path& building() const { return building_; }
  /// True where an earlier conversion wrote the last byte, and at most the name is left to change.
  bool finished() const { return finished_; }
  /// Removes what an earlier conversion left. requires: not finished().
  void clear();
  /// The built store loses what only a resumed conversion needs, and takes its name. throws: Error kIo; what was at
  /// `out` is then still there.
  void commit();
  /// After it, the store that an interrupted conversion had moved aside for this one, where there is one.
  const std::filesystem::path& leftOld() const { return left_old_; }
  /// What was built stays, and is no store.
  void keepForResuming() noexcept;
  /// Removes what was built.
  void abandon() noexcept;

 private:
  void tidy() noexcept;
  // Where the store that is replaced waits until the new one has its name.
  std::filesystem::path old() const;
  void requirePlaceForOld() const;
  std::filesystem::path out_, building_, left_old_;
  FileSystem& disk_;
  bool finished_ = false;
};

}  // namespace kiln
