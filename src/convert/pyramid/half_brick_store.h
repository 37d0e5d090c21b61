// Holds the parts of bricks until their parents are built. Each part is cut into a piece per parent: most of it is
// freed with the main parent, and only a few voxels wait for the neighbours. Pieces lie in memory up to a limit, then
// in a folder of the unfinished store, one file per part. The files do not outlive the process: a resumed conversion
// makes the needed parts anew.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "base/file/file.h"
#include "convert/pyramid/half_brick.h"

namespace kiln {

/// The voxels of a brick for one parent.
struct HalfBrickPiece {
  BrickKey parent;
  HalfBrick part;
};

class HalfBrickStore {
 public:
  /// Empties or makes `directory`. Pieces up to `memory_bytes` in total stay in memory. throws: Error kNoSpace, kIo.
  HalfBrickStore(const std::filesystem::path& directory, std::uint64_t memory_bytes, FileSystem& disk);
  /// Removes the directory.
  ~HalfBrickStore();
  HalfBrickStore(const HalfBrickStore&) = delete;
  HalfBrickStore& operator=(const HalfBrickStore&) = delete;

  /// Stores all pieces of a brick. thread: safe for different keys. throws: Error kNoSpace, kIo.
  void put(const BrickKey& key, std::vector<HalfBrickPiece> pieces);
  /// Returns and removes a brick's piece for a parent. requires: the piece was put and not taken.
  /// thread: safe. throws: Error kIo, kFormat, kNotFound.
  HalfBrick take(const BrickKey& key, const BrickKey& parent);

  /// Memory of the table for the pieces of a brick, beside the parts themselves. unit: bytes.
  static std::uint64_t placesBytes(std::uint64_t pieces) { return kNodeBytes + pieces * sizeof(Piece); }

 private:
  // A range of a part's file. unit: bytes.
  struct Stretch {
    std::uint64_t offset = 0, bytes = 0;
  };
  struct Piece {
    BrickKey parent;
    std::unique_ptr<HalfBrick> part;  // null if the piece is on disk, at `stretch`
    Stretch stretch;
  };
  using Pieces = std::vector<Piece>;
  // Allocated size of a map node and the head of its vector. unit: bytes.
  static constexpr std::uint64_t kNodeBytes = 96;

  bool reserve(std::uint64_t bytes);
  Pieces written(const BrickKey& key, const std::vector<HalfBrickPiece>& pieces);
  std::filesystem::path pathOf(const BrickKey& key) const;

  std::filesystem::path directory_;
  FileSystem& disk_;
  mutable std::mutex mutex_;  // guards the members below
  std::map<BrickKey, Pieces> left_;
  std::uint64_t free_bytes_;
};

}  // namespace kiln
