// The interface of a supplier of bricks for a cache, such as other ranks; brick files as on disk.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "grid/coords.h"
#include "store/bricked_volume.h"
#include "store/codec/brick_block.h"

namespace kiln {

struct BrickFile {
  std::shared_ptr<const std::vector<std::byte>> bytes;
  bool from_disk = true;  // read from disk for this request; false if the file was in the memory of any rank
};

struct SuppliedBrick {
  BrickBlock block;
  bool from_disk = true;  // as in BrickFile
};

class BrickSupplier {
 public:
  virtual ~BrickSupplier() = default;
  /// Returns a brick of the cache's volumes. May wait. requires: the brick is not constant. thread: safe. throws: as
  /// BrickedVolume::read.
  virtual SuppliedBrick supply(const StoredBrick& brick) = 0;
};

}  // namespace kiln
