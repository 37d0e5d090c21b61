// A cache of brick files, as on disk, under a memory budget.
// Method. Concurrent requests for a brick share one read. The least recently used file is evicted first.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "cache/brick_files.h"
#include "store/store_reader.h"

namespace kiln {

class EncodedBricks {
 public:
  explicit EncodedBricks(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// Returns a file from memory, or reads and keeps the file if the budget has room. An evicted file stays valid for
  /// all holders, outside the budget. Files not `likely` to be requested again are evicted first.
  /// thread: safe. throws: as StoreReader::readFile.
  BrickFile get(const StoreReader& store, const StoredBrick& brick, bool likely = true);

 private:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  using Recency = std::list<std::pair<StoredBrick, Bytes>>;
  void keep(const StoredBrick& brick, Bytes bytes, bool likely);

  const std::uint64_t budget_bytes_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::uint64_t held_bytes_ = 0;
  Recency recency_;  // most recent first; unlikely files last
  std::map<StoredBrick, Recency::iterator> places_;
  std::set<StoredBrick> being_read_;
};

}  // namespace kiln
