// Writes a store so that it becomes one at a single instant: bricks, then the index, then, last and atomically, the
// manifest (FORMAT.md).
#pragma once

#include <filesystem>
#include <mutex>
#include <span>

#include "base/file.h"
#include "store/brick_codec.h"
#include "store/brick_index.h"
#include "store/manifest.h"

namespace kiln {

class StoreWriter {
 public:
  /// `draft` has all but what the bricks decide (range, histogram, stored counts, index checksum).
  /// throws: Error kExists where `directory` holds anything, kNoSpace, kIo.
  StoreWriter(const std::filesystem::path& directory, Manifest draft, FileSystem& disk);

  /// Encodes and writes one brick, or notes that it is constant. shape: `voxels` covers frame(key).stored().
  /// thread: safe for different keys. throws: Error kNoSpace, kIo.
  void put(const BrickKey& key, std::span<const std::byte> voxels);
  BrickFrame frame(const BrickKey& key) const;

  /// Writes the index and the manifest; from here on the directory is a store. requires: every brick was put.
  void finish(const ValueHistogram& histogram, std::uint64_t nan_count);

  /// The range of all voxels put so far, NaN aside. thread: not while bricks are being put.
  const ValueRange& range() const { return manifest_.range; }
  /// Brick files so far, and their bytes. thread: as range.
  std::uint64_t storedBricks() const { return manifest_.levels.front().stored_bricks; }
  std::uint64_t bytesWritten() const { return manifest_.levels.front().stored_bytes; }

 private:
  std::filesystem::path directory_;
  Manifest manifest_;
  FileSystem& disk_;
  BrickIndex index_;
  std::mutex mutex_;
};

/// bricks/L/X_Y_Z.vdb
std::filesystem::path brickPath(const BrickKey& key);

}  // namespace kiln
