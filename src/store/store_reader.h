// Opens a store and reads its bricks. The checksum of a file is tested before any byte is interpreted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "store/bricked_volume.h"

namespace kiln {

struct FileIdentity;

class StoreReader final : public BrickedVolume {
 public:
  /// Opens a store, even while a conversion replaces it. The index, and for a moment its file, must fit in
  /// `memory_bytes`, of which `held_bytes` are in use. throws: Error kNotFound, kFormat (no manifest: an unfinished
  /// conversion, or no store), kDamaged; kBudget, naming the needed memory, before the index is read.
  explicit StoreReader(const std::filesystem::path& directory, std::uint64_t memory_bytes = UINT64_MAX,
                       std::uint64_t held_bytes = 0);

  /// Reads, checks and decodes a brick; a constant brick needs no I/O. thread: safe.
  /// throws: Error kDamaged, naming the file and both checksums, kNotFound, kIo; kReplaced, as requireUnchanged, if a
  /// file is missing or does not match the index.
  BrickBlock read(const BrickKey& key) const override;
  /// throws: Error kDamaged if the volume's type has no such value.
  std::optional<double> constantOf(const BrickKey& key) const override;
  /// The two steps of `read` for a brick that is not constant, for bytes that come from elsewhere: the checked file,
  /// and its decoded brick. requires: `file` passes `check`. thread: safe. throws: as `read`.
  std::vector<std::byte> readFile(const BrickKey& key) const;
  BrickBlock decode(const BrickKey& key, std::span<const std::byte> file) const;
  /// True if bytes that this process has not read itself equal the brick's file, by size and checksum.
  bool check(const BrickKey& key, std::span<const std::byte> file) const;
  /// Checks that the opened store still has its name, for files that are read by name without a checksum. throws: Error
  /// kReplaced, kIo.
  void requireUnchanged() const;
  std::size_t readBytes(const BrickKey& key) const override;
  /// Size of the largest brick file. unit: bytes.
  std::uint64_t largestFileBytes() const;
  std::unique_ptr<BrickedVolume> share() const override;

 private:
  void open(std::uint64_t memory_bytes, std::uint64_t held_bytes);
  /// Returns a file of the store; errors name the file below `path()`.
  template <class Bytes>
  Bytes checkedFile(const std::filesystem::path& name, std::uint64_t bytes, const Hash128& checksum) const;
  template <class Bytes>
  Bytes bytesOfFile(const BrickKey& key) const;

  std::filesystem::path folder_;  // absolute: a program may change its working directory between reads
  std::shared_ptr<const std::optional<FileIdentity>> opened_;  // identity of the manifest; nothing if there was no file
};

/// True if `directory` has a manifest and thus is a store. StoreReader tests whether the store is intact.
bool isStore(const std::filesystem::path& directory);

/// Refuses a new path inside the folder of a store, finished or not, which holds only its own files. Call before the
/// path is made. Follows links. `option` names the path in the message. throws: Error kUsage.
void requireOutsideStores(const std::filesystem::path& path, const std::string& option = "");

}  // namespace kiln
