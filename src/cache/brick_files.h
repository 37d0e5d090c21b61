// Brick files as they are on the disk, and where a cache gets them from if not from there itself.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "store/store_reader.h"

namespace kiln {

/// A brick of one of the stores that a cache is of.
struct StoredBrick {
  BrickKey key;
  int store = 0;  // its place among them
  auto operator<=>(const StoredBrick&) const = default;
};

struct BrickFile {
  std::shared_ptr<const std::vector<std::byte>> bytes;
  bool from_disk = true;  // it was read for this question; else it was in somebody's memory
};

class BrickFiles {
 public:
  virtual ~BrickFiles() = default;
  /// The checked bytes of a brick's file. requires: the brick is not constant. thread: safe; it may wait. throws: as
  /// StoreReader::readFile.
  virtual BrickFile fetch(const StoreReader& store, const BrickKey& key) = 0;
};

}  // namespace kiln
