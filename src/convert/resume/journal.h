// The finished bricks of a conversion, recorded as they are written; a resumed conversion continues from the journal.
// It is not a part of a store, and is removed once the manifest is written.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/file/file.h"
#include "convert/stream/value_counter.h"
#include "store/brick_index.h"

namespace kiln {

/// Text that identifies the result of a conversion: conversions of equal `volume` write equal bricks.
struct ConversionIdentity {
  std::string volume;         // source files with sizes and times, geometry, type, options, library versions
  std::string command, time;  // of the first run, for the manifest
};

struct FinishedBrick {
  BrickKey key;
  BrickEntry entry;
  ValueCounts counts;  // of the core's voxels; empty above level 0
};

/// Converts a brick to bytes and back; nothing if the bytes are no brick.
std::vector<std::byte> bytesOf(const FinishedBrick& brick);
std::optional<FinishedBrick> finishedBrickFrom(std::span<const std::byte> bytes);

class Journal {
 public:
  /// Begins a journal in `directory` with the bricks of an existing journal for which keep(brick) returns true; `keep`
  /// also gets the counts. memory: one record. throws: Error kNoSpace, kIo.
  Journal(const std::filesystem::path& directory, const ConversionIdentity& identity,
          const std::function<bool(const FinishedBrick&)>& keep, FileSystem& disk);
  /// thread: safe. throws: Error kNoSpace, kIo.
  void append(const FinishedBrick& brick);

  /// Returns the identity in the journal of `directory`; nothing if there is no journal or its begin is damaged.
  /// throws: Error kIo.
  static std::optional<ConversionIdentity> identityIn(const std::filesystem::path& directory);
  /// Calls take(brick) for the bricks of the journal, up to the first record that is not whole. Files of these bricks
  /// may be damaged, and a brick may come twice. memory: one record. throws: Error kIo.
  static void forEachBrick(const std::filesystem::path& directory,
                           const std::function<void(const FinishedBrick&)>& take);
  static std::filesystem::path pathIn(const std::filesystem::path& directory);

 private:
  std::filesystem::path path_;
  FileSystem& disk_;
  std::mutex mutex_;
};

}  // namespace kiln
