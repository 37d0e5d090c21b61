// The interface of a source of brick files for a cache, such as other ranks.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "store/store_reader.h"
#include "store/stored_brick.h"

namespace kiln {

struct BrickFile {
  std::shared_ptr<const std::vector<std::byte>> bytes;
  bool from_disk = true;  // read from disk for this request; false if the file was in the memory of any rank
};

class BrickFiles {
 public:
  virtual ~BrickFiles() = default;
  /// Returns the bytes of a brick's file, with a valid checksum. May wait. requires: the brick is not constant. thread:
  /// safe. throws: as StoreReader::readFile.
  virtual BrickFile fetch(const StoreReader& store, const BrickKey& key) = 0;
};

}  // namespace kiln
