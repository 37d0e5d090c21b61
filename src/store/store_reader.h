// Opens a store and reads its bricks, each checked against its checksum before a byte of it is interpreted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "base/hash.h"
#include "base/same_file.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"
#include "store/manifest/manifest.h"

namespace kiln {

class StoreReader {
 public:
  /// Opens the store of that name, also while a conversion puts a new store there. The index, and for a moment its
  /// file, take memory out of `memory_bytes`, of which `held_bytes` are in use. throws: Error kNotFound, kFormat (no
  /// manifest: an unfinished conversion, or no store), kDamaged; kBudget, before the index is read, with the memory
  /// that reading takes.
  explicit StoreReader(const std::filesystem::path& directory, std::uint64_t memory_bytes = UINT64_MAX,
                       std::uint64_t held_bytes = 0);

  const std::filesystem::path& path() const { return directory_; }
  const Manifest& manifest() const { return manifest_; }
  /// Moves the volume into the frame and unit of a picture's world, as Manifest::placeIn. requires: no other thread
  /// reads from the store.
  void placeIn(const VolumeGeometry& world) { manifest_.placeIn(world); }
  const BrickIndex& index() const { return index_; }
  /// throws: Error kUsage where the store has no such level.
  void requireLevel(int level) const;
  const LevelInfo& level(int level) const { return manifest_.levels[static_cast<std::size_t>(level)]; }
  BrickDesc frame(const BrickKey& key) const;

  /// Reads, checks and decodes a brick; a constant one costs no I/O. thread: safe.
  /// throws: Error kDamaged naming the file and both checksums, kNotFound, kIo; kReplaced as requireUnchanged, where a
  /// file is missing or does not fit the index.
  BrickBlock read(const BrickKey& key) const;
  /// The two halves of `read` of a brick that is not constant, for bytes that come another way: the file, checked, and
  /// the brick that it is. requires: `file` has passed `check`. thread: safe. throws: as `read`.
  std::vector<std::byte> readFile(const BrickKey& key) const;
  BrickBlock decode(const BrickKey& key, std::span<const std::byte> file) const;
  /// Whether bytes that this process has not read itself are those of the brick's file.
  bool check(const BrickKey& key, std::span<const std::byte> file) const;
  /// For files that are read by their names and without a check: that the store which was opened is still the one of
  /// its name. throws: Error kReplaced, kIo.
  void requireUnchanged() const;
  /// The memory that `read` holds at its peak, the result included. unit: bytes.
  std::size_t readBytes(const BrickKey& key) const;

  /// The most of these over all bricks: less memory than this reads no picture. unit: bytes.
  std::uint64_t largestReadBytes() const;
  /// The largest brick file. unit: bytes.
  std::uint64_t largestFileBytes() const;

 private:
  void open(std::uint64_t memory_bytes, std::uint64_t held_bytes);
  template <class Bytes>
  Bytes checkedFile(const std::filesystem::path& path, std::uint64_t bytes, const Hash128& checksum) const;
  template <class Bytes>
  Bytes bytesOfFile(const BrickKey& key) const;

  std::filesystem::path directory_;
  std::optional<FileIdentity> opened_;  // of the manifest
  Manifest manifest_;
  BrickIndex index_;
};

/// Whether `directory` has a manifest, by which it is a store; whether that is whole is for StoreReader to see.
bool isStore(const std::filesystem::path& directory);

/// Before something new of this name is made: that it will not be in the folder of a store, finished or not, which
/// holds nothing but its own files. Links are followed. `option` is what named it, for the message. throws: Error
/// kUsage.
void requireOutsideStores(const std::filesystem::path& path, const std::string& option = "");

}  // namespace kiln
