// Where the parts of bricks wait whose parents are not yet built: cut into a piece for each parent, which is all that
// it needs, so that most of a part goes with the parent that it is the core of, and its neighbours' few voxels later.
// In memory as far as they may, then in a folder of the store being written, one file a part. Nothing here outlives the
// process: a resumed conversion makes the parts it needs anew.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "base/file.h"
#include "convert/pyramid/half_brick.h"

namespace kiln {

/// What a brick gives to one parent.
struct HalfBrickPiece {
  BrickKey parent;
  HalfBrick part;
};

class HalfBrickStore {
 public:
  /// `directory` is emptied, or made. Pieces of `memory_bytes` together have no file. throws: Error kNoSpace, kIo.
  HalfBrickStore(const std::filesystem::path& directory, std::uint64_t memory_bytes, FileSystem& disk);
  /// Removes it.
  ~HalfBrickStore();
  HalfBrickStore(const HalfBrickStore&) = delete;
  HalfBrickStore& operator=(const HalfBrickStore&) = delete;

  /// Keeps all of a brick's pieces. thread: safe for different keys. throws: Error kNoSpace, kIo.
  void put(const BrickKey& key, std::vector<HalfBrickPiece> pieces);
  /// Gives back a brick's piece for a parent, which is then forgotten. requires: it was put, and not taken. thread:
  /// safe. throws: Error kIo, kFormat, kNotFound.
  HalfBrick take(const BrickKey& key, const BrickKey& parent);

  /// What a brick's places of so many pieces take, in memory or on disk, beside the parts themselves. unit: bytes.
  static std::uint64_t placesBytes(std::uint64_t pieces) { return kNodeBytes + pieces * sizeof(Piece); }

 private:
  // In a part's file. unit: bytes.
  struct Stretch {
    std::uint64_t offset = 0, bytes = 0;
  };
  struct Piece {
    BrickKey parent;
    std::unique_ptr<HalfBrick> part;  // null where it is on disk, at `stretch`
    Stretch stretch;
  };
  using Pieces = std::vector<Piece>;
  // A node of the map and the head of its list, as they are allocated.
  static constexpr std::uint64_t kNodeBytes = 96;

  bool reserve(std::uint64_t bytes);
  Pieces written(const BrickKey& key, const std::vector<HalfBrickPiece>& pieces);
  std::filesystem::path pathOf(const BrickKey& key) const;

  std::filesystem::path directory_;
  FileSystem& disk_;
  mutable std::mutex mutex_;  // guards what follows
  std::map<BrickKey, Pieces> left_;
  std::uint64_t free_bytes_;
};

}  // namespace kiln
