// Writes a store so that it becomes one at a single instant: bricks, then the index, then, last and atomically, the
// manifest (FORMAT.md).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/file.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"
#include "store/codec/brick_ranges.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// A brick on its way to the disk. `file` is empty where `entry` says that it is constant.
struct EncodedBrick {
  BrickKey key;
  BrickEntry entry;
  std::vector<std::byte> file;
};

class StoreWriter {
 public:
  /// `draft` has all but what the bricks decide (range, histogram, stored counts, index checksum).
  /// Bricks that are in `directory` already are replaced or kept, as the caller says. throws: Error kExists where
  /// `directory` is a store, kNoSpace, kIo.
  /// With `sub_ranges_on_disk` the sub-ranges of bricks, the most of a large index, are in a scratch file until the
  /// store is finished.
  StoreWriter(const std::filesystem::path& directory, Manifest draft, FileSystem& disk,
              bool sub_ranges_on_disk = false);

  /// Makes the file of one brick, or notes that it is constant, and enters it in the index; it is still to be written.
  /// shape: `voxels` covers frame(key).stored(). thread: safe for different keys.
  EncodedBrick encode(const BrickKey& key, std::span<const std::byte> voxels, const BrickRanges& ranges);
  /// thread: safe for different keys. throws: Error kNoSpace, kIo.
  void write(const EncodedBrick& brick);
  /// Enters a brick that another writer has written, or is writing: an earlier one, or one of another process. thread:
  /// safe for different keys.
  void keep(const BrickKey& key, const BrickEntry& entry);
  bool contains(const BrickKey& key) const { return index_.contains(key); }
  BrickDesc frame(const BrickKey& key) const;
  const Manifest& manifest() const { return manifest_; }
  /// Without sub-ranges where these are on disk. requires: the brick was encoded or kept. thread: safe beside encoding
  /// other bricks.
  const BrickEntry& entry(const BrickKey& key) const { return index_.at(key); }
  /// With its sub-ranges. requires, thread: as `entry`.
  BrickEntry wholeEntry(const BrickKey& key) const;

  /// The range of all voxels, NaN aside. requires: every brick is entered.
  ValueRange range() const;
  /// Writes the index and the manifest; from here on the directory is a store. requires: every brick was written.
  void finish(const ValueHistogram& histogram, std::uint64_t nan_count);

  /// Brick files of all levels, and their bytes. requires: finished.
  std::uint64_t storedBricks() const;
  std::uint64_t bytesWritten() const;

 private:
  void countStored();
  std::shared_ptr<const SubRanges> subRangesAt(std::size_t place) const;
  std::filesystem::path directory_;
  Manifest manifest_;
  FileSystem& disk_;
  const WriteMode brick_mode_;
  BrickIndex index_;
  std::optional<File> sub_ranges_;  // on disk, one after the other in the order of the index
};

/// Where a directory holds some bricks only, which box of the volume they are for (kiln split).
inline constexpr const char* kPartFile = "part.txt";

/// bricks/L/X_Y_Z.vdb
std::filesystem::path brickPath(const BrickKey& key);

}  // namespace kiln
