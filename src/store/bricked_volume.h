// The interface of a volume that is read brick by brick: a store on disk (store/store_reader.h), or an array in memory
// (convert/open_array.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "grid/coords.h"
#include "store/manifest/manifest.h"

namespace kiln {

struct BrickBlock;
struct BrickDesc;
class BrickIndex;

/// A brick of one of several volumes.
struct StoredBrick {
  BrickKey key;
  int store = 0;  // index of the volume among the volumes
  auto operator<=>(const StoredBrick&) const = default;
};

class BrickedVolume {
 public:
  virtual ~BrickedVolume();

  /// The volume's name in messages; of a store, its folder.
  const std::filesystem::path& path() const { return path_; }
  const Manifest& manifest() const { return manifest_; }
  /// Moves the volume into the frame and unit of a picture's world, as Manifest::placeIn. requires: no other thread
  /// reads the volume.
  void placeIn(const VolumeGeometry& world) { manifest_.placeIn(world); }
  const BrickIndex& index() const { return *index_; }
  /// throws: Error kUsage if the volume has no such level.
  void requireLevel(int level) const;
  const LevelInfo& level(int level) const { return manifest_.levels[static_cast<std::size_t>(level)]; }
  BrickDesc frame(const BrickKey& key) const;

  /// Returns a brick. thread: safe. throws: the errors of the volume's kind.
  virtual BrickBlock read(const BrickKey& key) const = 0;
  /// Returns the value of a brick whose voxels are equal, which costs no `read`; nothing for other bricks. throws: as
  /// `read`.
  virtual std::optional<double> constantOf(const BrickKey& key) const;
  /// Peak memory of `read`, including the result. unit: bytes.
  virtual std::size_t readBytes(const BrickKey& key) const = 0;
  /// Upper bound of the memory of a brick that `read` returned. unit: bytes.
  virtual std::size_t blockBytes(const BrickKey& key) const;
  /// The largest `readBytes` of all bricks: the least memory that can read a picture. unit: bytes.
  std::uint64_t largestReadBytes() const;
  /// Memory that the volume holds: its index, and voxels of its own. unit: bytes.
  virtual std::uint64_t heldBytes() const;
  /// Returns the volume with a place in the world of its own. cost: index and voxels are shared.
  virtual std::unique_ptr<BrickedVolume> share() const = 0;

  /// Returns the finest level of at most 128 voxels a side and 64 bricks, else the finest level of one brick; nothing
  /// without such levels. Cameras are fitted to this level, so each part of a split store holds all its bricks.
  std::optional<int> overviewLevel() const;

 protected:
  explicit BrickedVolume(std::filesystem::path path);
  BrickedVolume(const BrickedVolume&);
  BrickedVolume& operator=(const BrickedVolume&) = delete;
  /// Sets the contents. requires: called before the volume is used.
  void hold(Manifest manifest, BrickIndex index);

 private:
  std::filesystem::path path_;
  Manifest manifest_;
  std::shared_ptr<const BrickIndex> index_;
};

}  // namespace kiln
