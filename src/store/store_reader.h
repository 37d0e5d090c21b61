// Opens a store and reads its bricks, each checked against its checksum before a byte of it is interpreted.
#pragma once

#include <filesystem>

#include "store/brick_codec.h"
#include "store/brick_index.h"
#include "store/manifest.h"

namespace kiln {

class StoreReader {
 public:
  /// throws: Error kNotFound, kFormat (no manifest: an unfinished conversion or not a store), kDamaged.
  explicit StoreReader(const std::filesystem::path& directory);

  const std::filesystem::path& path() const { return directory_; }
  const Manifest& manifest() const { return manifest_; }
  const BrickIndex& index() const { return index_; }
  const LevelInfo& level(int level) const { return manifest_.levels[static_cast<std::size_t>(level)]; }
  BrickFrame frame(const BrickKey& key) const;

  /// Reads, checks and decodes a brick; a constant one costs no I/O. thread: safe.
  /// throws: Error kDamaged naming the file and both checksums, kNotFound, kIo.
  BrickBlock read(const BrickKey& key) const;
  /// The memory that `read` holds at its peak, the result included. unit: bytes.
  std::size_t readBytes(const BrickKey& key) const;

  /// The most of these over all bricks: less memory than this reads no picture. unit: bytes.
  std::uint64_t largestReadBytes() const;

 private:
  std::vector<std::byte> readFileOf(const BrickKey& key) const;
  std::filesystem::path directory_;
  Manifest manifest_;
  BrickIndex index_;
};

/// Whether `directory` looks like a store (has a manifest), finished and whole or not.
bool isStore(const std::filesystem::path& directory);

}  // namespace kiln
