// The index of a store (FORMAT.md, index.bin): an entry per brick and level. An entry decides whether a brick is worth
// reading, and holds the checksum of the brick's file.
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
  bool masked = false;  // a mask hides all voxels: both ranges are empty. Not part of index.bin
  ValueRange core;      // values of the brick's own voxels and of finer levels
  ValueRange support;   // core and apron: bounds every value interpolated in the brick
  std::uint64_t file_bytes = 0;
  Hash128 checksum;
  /// Within `support`. Null for a constant brick, and in a store of a format without sub-ranges.
  std::shared_ptr<const SubRanges> sub_ranges;
};

/// Appends the bytes of an entry in index.bin.
void appendEntry(std::vector<std::byte>& out, const BrickEntry& entry);
/// Reads an entry from the front of `bytes`. Returns nothing, and leaves `bytes` unchanged, if there is no whole, valid
/// entry.
std::optional<BrickEntry> takeEntry(std::span<const std::byte>& bytes);

class BrickIndex {
 public:
  BrickIndex() = default;
  /// shape: the brick lattice of each level.
  explicit BrickIndex(std::vector<Extent3> lattices);

  int levels() const { return static_cast<int>(lattices_.size()); }
  const Extent3& lattice(int level) const { return lattices_[static_cast<std::size_t>(level)]; }
  bool contains(const BrickKey& key) const;
  /// Size of an index file for so many bricks with files and so many constant bricks. unit: bytes.
  static std::uint64_t fileBytes(std::uint64_t stored, std::uint64_t constant, std::int64_t brick_size);
  /// requires: contains(key).
  const BrickEntry& at(const BrickKey& key) const { return entries_[place(key)]; }
  BrickEntry& at(const BrickKey& key) { return entries_[place(key)]; }
  std::size_t size() const { return entries_.size(); }
  /// Position of a brick among all bricks of all levels. requires: contains(key).
  std::size_t place(const BrickKey& key) const;
  /// Calls each(key) for the bricks of all levels, in the order of `place`.
  template <class Each>
  void forEachKey(const Each& each) const {
    for (int level = 0; level < levels(); ++level)
      for (std::int64_t i = 0; i < lattice(level).count(); ++i) each(BrickKey{level, brickAt(lattice(level), i)});
  }
  /// The range of all voxels of level 0, ignoring NaN. requires: level 0 has all its entries.
  ValueRange valueRange() const;
  /// Returns the largest of bytes_of(key) over all bricks.
  std::uint64_t largest(const std::function<std::uint64_t(const BrickKey&)>& bytes_of) const;
  /// Memory of the index. unit: bytes.
  std::uint64_t bytes() const;
  /// Memory of an index for so many bricks with files and so many constant bricks. unit: bytes.
  static std::uint64_t bytesOf(std::uint64_t stored, std::uint64_t constant, std::int64_t brick_size);
  /// Memory of a brick's sub-ranges beside its entry, for `along` sub-bricks per axis. unit: bytes.
  static std::uint64_t subRangesBytes(int along);

  /// Returns the sub-ranges of the brick at a position whose entry has none in memory.
  using SubRangesAt = std::function<std::shared_ptr<const SubRanges>(std::size_t place)>;
  /// Calls take(bytes) for each piece of the index file in order. `missing` is called for bricks with a file and
  /// without sub-ranges in memory; if `missing` is empty, such bricks are written without sub-ranges. cost: memory of a
  /// piece.
  void encode(const std::function<void(std::span<const std::byte>)>& take, const SubRangesAt& missing = {}) const;
  /// Returns the whole index file.
  std::vector<std::byte> encode() const;
  /// throws: Error kFormat, naming `path`, if the bytes are no index of these lattices.
  static BrickIndex decode(std::span<const std::byte> data, const std::vector<Extent3>& lattices,
                           const std::filesystem::path& path);

 private:
  std::vector<Extent3> lattices_;
  std::vector<std::size_t> first_;  // position of each level in entries_
  std::vector<BrickEntry> entries_;
};

}  // namespace kiln
