// The files of bricks in memory, as they are on the disk, under a budget: each is read once for all who ask at the same
// time, and again only when it had to make room. The least recently used goes first.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "cache/brick_files.h"

namespace kiln {

class EncodedBricks {
 public:
  explicit EncodedBricks(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// From memory, else from `store`'s disk; it is kept where the budget has room for it. What has been handed out is
  /// its holder's, and no longer in the budget when it has made room. What is not `likely` to be asked for again makes
  /// room first. thread: safe. throws: as StoreReader::readFile.
  BrickFile get(const StoreReader& store, const StoredBrick& brick, bool likely = true);

 private:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  using Recency = std::list<std::pair<StoredBrick, Bytes>>;
  void keep(const StoredBrick& brick, Bytes bytes, bool likely);

  const std::uint64_t budget_bytes_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::uint64_t held_bytes_ = 0;
  Recency recency_;  // most recent first, what is not likely last
  std::map<StoredBrick, Recency::iterator> places_;
  std::set<StoredBrick> being_read_;
};

}  // namespace kiln
