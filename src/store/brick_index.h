// One entry a brick and level (FORMAT.md, index.bin): enough to decide whether a brick is worth reading, and to know
// that what was read is what was written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/hash.h"
#include "grid/coords.h"
#include "grid/value_range.h"
#include "store/ranges/sub_bricks.h"

namespace kiln {

struct BrickEntry {
  bool constant = false;
  ValueRange core;     // of the brick's own voxels
  ValueRange support;  // of core and apron: bounds every value that is interpolated in them
  std::uint64_t file_bytes = 0;
  Hash128 checksum;
  /// Within `support`. Null for a constant brick, and where the store is of a format that had none.
  std::shared_ptr<const SubRanges> sub_ranges;
};

/// Adds the bytes of an entry in index.bin.
void appendEntry(std::vector<std::byte>& out, const BrickEntry& entry);
/// Takes an entry from the front of `bytes`; nothing, and leaves them, where they end before it does or are none.
std::optional<BrickEntry> takeEntry(std::span<const std::byte>& bytes);

class BrickIndex {
 public:
  BrickIndex() = default;
  /// shape: the brick lattice of each level.
  explicit BrickIndex(std::vector<Extent3> lattices);

  int levels() const { return static_cast<int>(lattices_.size()); }
  const Extent3& lattice(int level) const { return lattices_[static_cast<std::size_t>(level)]; }
  bool contains(const BrickKey& key) const;
  /// The size of the file of an index, of so many bricks that have files and so many of one value. unit: bytes.
  static std::uint64_t fileBytes(std::uint64_t stored, std::uint64_t constant, std::int64_t brick_size);
  /// requires: contains(key).
  const BrickEntry& at(const BrickKey& key) const { return entries_[place(key)]; }
  BrickEntry& at(const BrickKey& key) { return entries_[place(key)]; }
  std::size_t size() const { return entries_.size(); }
  /// The place of a brick among all bricks of all levels. requires: contains(key).
  std::size_t place(const BrickKey& key) const;
  /// What it costs in memory. unit: bytes.
  std::uint64_t bytes() const;
  /// The same of an index of so many bricks that have files and so many of one value. unit: bytes.
  static std::uint64_t bytesOf(std::uint64_t stored, std::uint64_t constant, std::int64_t brick_size);
  /// What sub-ranges of a brick cost in memory beside its entry, `along` of them along an axis. unit: bytes.
  static std::uint64_t subRangesBytes(int along);

  /// Gives the sub-ranges of the brick at a place whose entry has none in memory.
  using SubRangesAt = std::function<std::shared_ptr<const SubRanges>(std::size_t place)>;
  /// Calls take(bytes) for one piece of the index's file after the other. `missing` is called for bricks with a file
  /// and without sub-ranges; where it is empty these are written without. memory: a piece.
  void encode(const std::function<void(std::span<const std::byte>)>& take, const SubRangesAt& missing = {}) const;
  /// All pieces in one.
  std::vector<std::byte> encode() const;
  /// throws: Error kFormat naming `path` where the bytes are not an index of these lattices.
  static BrickIndex decode(std::span<const std::byte> data, const std::vector<Extent3>& lattices,
                           const std::filesystem::path& path);

 private:
  std::vector<Extent3> lattices_;
  std::vector<std::size_t> first_;  // of each level in entries_
  std::vector<BrickEntry> entries_;
};

}  // namespace kiln
