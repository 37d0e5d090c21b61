// Writes a store.
// Method. Bricks are written first, then the index, and last, atomically, the manifest (FORMAT.md).
// Invariant. A directory becomes a store in one instant; an interrupted conversion never looks like a store.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/file/file.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"
#include "store/codec/brick_ranges.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// A brick on its way to the disk. `file` is empty if the entry is constant.
struct EncodedBrick {
  BrickKey key;
  BrickEntry entry;
  std::vector<std::byte> file;
};

/// Returns the entry of a brick, without size and checksum of its file. shape: `voxels` covers brick.stored().
BrickEntry entryOf(const BrickDesc& brick, std::span<const std::byte> voxels, const BrickRanges& ranges);

class StoreWriter {
 public:
  /// `draft` holds everything except the results of the bricks (range, histogram, stored counts, index checksum).
  /// Bricks already in `directory` are replaced or adopted by the caller. With `sub_ranges_on_disk` the sub-ranges, the
  /// largest part of a large index, lie in a scratch file until `finish`.
  /// throws: Error kExists if `directory` is a store, kNoSpace, kIo.
  StoreWriter(const std::filesystem::path& directory, Manifest draft, FileSystem& disk,
              bool sub_ranges_on_disk = false);

  /// Encodes the file of a brick, or marks the brick as constant, and enters it in the index; call `write` afterwards.
  /// shape: `voxels` covers frame(key).stored(). thread: safe for different keys.
  EncodedBrick encode(const BrickKey& key, std::span<const std::byte> voxels, const BrickRanges& ranges);
  /// thread: safe for different keys. throws: Error kNoSpace, kIo.
  void write(const EncodedBrick& brick);
  /// Enters a brick that an earlier run or another process writes. thread: safe for different keys.
  void keep(const BrickKey& key, const BrickEntry& entry);
  bool contains(const BrickKey& key) const { return index_.contains(key); }
  BrickDesc frame(const BrickKey& key) const;
  const Manifest& manifest() const { return manifest_; }
  /// Returns the entry, without sub-ranges if these are on disk. requires: the brick was encoded or kept. thread: safe
  /// while other bricks are encoded.
  const BrickEntry& entry(const BrickKey& key) const { return index_.at(key); }
  /// Returns the entry with its sub-ranges. requires, thread: as `entry`.
  BrickEntry wholeEntry(const BrickKey& key) const;

  /// The range of all voxels, ignoring NaN. requires: every brick is entered.
  ValueRange range() const;
  /// Writes index and manifest; afterwards the directory is a store. requires: every brick was written.
  void finish(const ValueHistogram& histogram, std::uint64_t nan_count);

  /// Number and bytes of the brick files of all levels. requires: finished.
  std::uint64_t storedBricks() const;
  std::uint64_t bytesWritten() const;

 private:
  void countStored();
  std::shared_ptr<const SubRanges> subRangesAt(std::size_t place) const;
  std::filesystem::path directory_;
  Manifest manifest_;
  FileSystem& disk_;
  const WritePolicy brick_policy_;
  BrickIndex index_;
  std::optional<File> sub_ranges_;  // on disk, in the order of the index
};

/// File in a directory with part of the bricks: the box of the volume that these bricks cover (kiln split).
inline constexpr const char* kPartFile = "part.txt";

/// Returns bricks/L/X_Y_Z.vdb.
std::filesystem::path brickPath(const BrickKey& key);

}  // namespace kiln
