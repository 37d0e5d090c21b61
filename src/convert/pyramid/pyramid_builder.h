// The coarser levels of a store, built while the finer bricks pass by: a parent as soon as every brick that its core
// and apron touch is there. Each brick leaves its half-resolution part behind, a piece for each of its parents.
// Where several processes share the work each builds its own of the coarser bricks, and what they need of a brick that
// another one made comes as a piece of that brick's part.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "convert/pyramid/half_brick_store.h"
#include "store/store_writer.h"

namespace kiln {

/// What of the pyramid one of several processes builds (ownerOf), and how the others get what they need.
struct PyramidShare {
  int rank = 0, ranks = 1;
  /// Gives what another rank's parents need of a brick: null where it is of one value, and its entry says all.
  std::function<void(int to, const BrickKey& key, const HalfBrick* piece)> give = {};
};

class PyramidBuilder {
 public:
  /// `parts` is a folder for this object alone, for what bricks leave behind beyond `parts_bytes` of them in memory.
  /// With `half` every mean is rounded to the nearest value that a half holds. requires: `writer` and `disk` outlive
  /// this.
  PyramidBuilder(StoreWriter& writer, const std::filesystem::path& parts, std::uint64_t parts_bytes, FileSystem& disk,
                 bool half, PyramidShare share = {});

  /// A brick has been encoded. Returns the bricks of the next level that can be built now, each once. shape: as
  /// coarsePartOf. thread: safe for different keys.
  std::vector<BrickKey> add(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                            const BrickRanges& ranges);
  /// The same of a brick that another rank made and gave. thread: as `add`.
  std::vector<BrickKey> addGiven(const BrickKey& key, const BrickEntry& entry, std::optional<HalfBrick> piece);
  /// The coarser bricks that this rank builds.
  std::uint64_t ownBricks() const;
  bool owns(const BrickKey& key) const { return ownerOf(key) == share_.rank; }
  struct Built {
    EncodedBrick brick;           // to be written
    std::vector<BrickKey> ready;  // as of `add`
  };
  /// The largest change of a mean by that rounding. unit: the volume's values.
  double largestError() const;
  /// Builds and encodes a brick that `add` or `takeUp` returned. thread: safe for different keys.
  Built build(const BrickKey& key);

  /// Takes up what an earlier conversion left: `finished(key)` says of every brick of the pyramid whether it is in the
  /// store being written; `again(key)` is called for each of them whose part is still needed, and must give voxels and
  /// ranges to `addFinished`. Returns the bricks that can be built. requires: nothing was added yet.
  std::vector<BrickKey> takeUp(const std::function<bool(const BrickKey&)>& finished,
                               const std::function<void(const BrickKey&)>& again);
  /// Only inside of `again`.
  void addFinished(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                   const BrickRanges& ranges);

 private:
  struct Level {
    Extent3 by;                          // from this level to the next
    std::vector<std::uint16_t> awaited;  // of a brick: bricks of the level below that it still waits for
    std::vector<char> built;             // of a brick: an earlier conversion did, and it needs no parts
  };
  bool hasNext(int level) const { return level + 1 < static_cast<int>(levels_.size()); }
  Extent3 lattice(int level) const { return writer_.manifest().levels[static_cast<std::size_t>(level)].bricks; }
  std::size_t place(const BrickKey& key) const;
  /// The bricks of the next level, or the one below, whose core and apron this one's voxels reach or are made of.
  VoxelBox parentsOf(const BrickKey& key) const;
  VoxelBox childrenOf(const BrickKey& key) const;
  bool keepsPart(const BrickKey& key) const;
  HalfBrick partOf(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                   const BrickRanges& ranges) const;
  int ownerOf(const BrickKey& key) const;
  /// What each rank's bricks take of the voxels that `key` makes in the next level.
  std::map<int, VoxelBox> takenOf(const BrickKey& key) const;
  /// This rank's parents that still need a brick's part.
  std::vector<BrickKey> waitingFor(const BrickKey& key) const;
  /// Leaves what they need of it; of what another rank gave, which may be less than the whole, too.
  void leave(const BrickKey& key, HalfBrick part);
  void gather(const BrickKey& child, const BrickKey& key, std::vector<std::byte>& voxels, BrickRanges& below);
  std::vector<BrickKey> arrived(const BrickKey& key);

  StoreWriter& writer_;
  HalfBrickStore parts_;
  const bool half_;
  const PyramidShare share_;
  std::vector<Level> levels_;
  mutable std::mutex mutex_;  // guards `awaited` and what follows
  double largest_error_ = 0;
};

}  // namespace kiln
