// What of a conversion is done, written beside the bricks as they are: what a resumed conversion goes on from. It is no
// part of a store, and is removed when the manifest is there.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/file.h"
#include "convert/stream/value_counter.h"
#include "store/brick_index.h"

namespace kiln {

/// What a conversion makes its store of, as text: two conversions with the same identity write the same bricks.
struct ConversionIdentity {
  std::string volume;         // source files with sizes and times, geometry, type, options, library versions
  std::string command, time;  // of the first run: what the manifest will say
};

struct FinishedBrick {
  BrickKey key;
  BrickEntry entry;
  ValueCounts counts;  // of the core's voxels; empty above level 0
};

/// A brick as bytes, and back; nothing where they are none.
std::vector<std::byte> bytesOf(const FinishedBrick& brick);
std::optional<FinishedBrick> finishedBrickFrom(std::span<const std::byte> bytes);

class Journal {
 public:
  /// Begins a journal in `directory` with the bricks of the one that is there, if there is one, of which keep(brick)
  /// says so; it is given the counts, too. memory: a record. throws: Error kNoSpace, kIo.
  Journal(const std::filesystem::path& directory, const ConversionIdentity& identity,
          const std::function<bool(const FinishedBrick&)>& keep, FileSystem& disk);
  /// thread: safe. throws: Error kNoSpace, kIo.
  void append(const FinishedBrick& brick);

  /// The conversion that the journal in `directory` is of; nothing where there is none or its beginning is damaged.
  /// throws: Error kIo.
  static std::optional<ConversionIdentity> identityIn(const std::filesystem::path& directory);
  /// Calls take(brick) for the bricks of the journal, up to the first record that is not whole. Their files may be
  /// damaged, and a brick may come twice. memory: a record. throws: Error kIo.
  static void forEachBrick(const std::filesystem::path& directory,
                           const std::function<void(const FinishedBrick&)>& take);
  static std::filesystem::path pathIn(const std::filesystem::path& directory);

 private:
  std::filesystem::path path_;
  FileSystem& disk_;
  std::mutex mutex_;
};

}  // namespace kiln
