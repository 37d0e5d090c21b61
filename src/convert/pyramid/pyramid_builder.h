// Builds the coarser levels of a store while the finer bricks pass by.
// Method. A parent is built as soon as all bricks under its core and apron have arrived. Each brick leaves a
// half-resolution part behind, cut into a piece for each parent.
// Several processes: each process builds a share of the coarser bricks, and receives pieces of bricks made elsewhere.
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

/// A process's share of the pyramid (ownerOf), and the function that sends pieces to ranks.
struct PyramidShare {
  int rank = 0, ranks = 1;
  /// Sends a brick's piece to the builder of its parents; null for a constant brick, whose entry is enough.
  std::function<void(int to, const BrickKey& key, const HalfBrick* piece)> give = {};
};

class PyramidBuilder {
 public:
  /// `parts` is a private folder for parts beyond `parts_bytes` of memory. With `half`, every mean is rounded to the
  /// nearest half float. requires: `writer` and `disk` outlive this.
  PyramidBuilder(StoreWriter& writer, const std::filesystem::path& parts, std::uint64_t parts_bytes, FileSystem& disk,
                 bool half, PyramidShare share = {});

  /// Adds an encoded brick. Returns the bricks of the next level that can be built now, each brick once. shape: as
  /// coarsePartOf. thread: safe for different keys.
  std::vector<BrickKey> add(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                            const BrickRanges& ranges);
  /// Adds a brick made by another rank. thread: as `add`.
  std::vector<BrickKey> addGiven(const BrickKey& key, const BrickEntry& entry, std::optional<HalfBrick> piece);
  /// The number of coarser bricks that this rank builds.
  std::uint64_t ownBricks() const;
  bool owns(const BrickKey& key) const { return ownerOf(key) == share_.rank; }
  struct Built {
    EncodedBrick brick;           // to be written
    std::vector<BrickKey> ready;  // as returned by `add`
  };
  /// The largest change of a mean by the rounding to half. unit: the volume's values.
  double largestError() const;
  /// Builds and encodes a brick that `add` or `resume` returned. thread: safe for different keys.
  Built build(const BrickKey& key);

  /// Resumes after an earlier conversion. `finished(key)` is true for every brick in the unfinished store. `again(key)`
  /// is called for each finished brick whose part is still needed, and must pass voxels and ranges to `addFinished`.
  /// Returns the bricks that can be built. requires: nothing was added yet.
  std::vector<BrickKey> resume(const std::function<bool(const BrickKey&)>& finished,
                               const std::function<void(const BrickKey&)>& again);
  /// requires: called by `again`.
  void addFinished(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                   const BrickRanges& ranges);

 private:
  struct Level {
    Extent3 by;                          // from this level to the next
    std::vector<std::uint16_t> awaited;  // by brick: bricks of the level below still awaited
    std::vector<char> built;             // by brick: built by an earlier conversion, needs no parts
  };
  bool hasNext(int level) const { return level + 1 < static_cast<int>(levels_.size()); }
  Extent3 lattice(int level) const { return writer_.manifest().levels[static_cast<std::size_t>(level)].bricks; }
  std::size_t place(const BrickKey& key) const;
  /// Parents: bricks of the next level whose core or apron uses the brick's voxels. Children: bricks of the level below
  /// that the brick's core and apron are made of.
  VoxelBox parentsOf(const BrickKey& key) const;
  VoxelBox childrenOf(const BrickKey& key) const;
  bool keepsPart(const BrickKey& key) const;
  HalfBrick partOf(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                   const BrickRanges& ranges) const;
  int ownerOf(const BrickKey& key) const;
  /// By rank, the voxels of the next level made from `key` that the rank's bricks need.
  std::map<int, VoxelBox> takenOf(const BrickKey& key) const;
  /// This rank's parents that still need a brick's part.
  std::vector<BrickKey> waitingFor(const BrickKey& key) const;
  /// Stores the pieces needed by this rank's parents; `part` may be a portion received from another rank.
  void leave(const BrickKey& key, HalfBrick part);
  void gather(const BrickKey& child, const BrickKey& key, std::vector<std::byte>& voxels, BrickRanges& below);
  std::vector<BrickKey> arrived(const BrickKey& key);

  StoreWriter& writer_;
  HalfBrickStore parts_;
  const bool half_;
  const PyramidShare share_;
  std::vector<Level> levels_;
  mutable std::mutex mutex_;  // guards `awaited` and the members below
  double largest_error_ = 0;
};

}  // namespace kiln
