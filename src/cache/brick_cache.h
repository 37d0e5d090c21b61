// Decoded bricks in memory, never more than the user said. Every byte a brick costs is charged, those that its decoding
// needs for a moment included; the least recently used brick that nobody holds makes room.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>

#include "store/store_reader.h"

namespace kiln {

struct CacheCounts {
  std::uint64_t reads = 0;       // bricks decoded from a file
  std::uint64_t read_bytes = 0;  // of those files
  std::uint64_t constants = 0;   // bricks made without a file
  std::uint64_t hits = 0;
  double load_seconds = 0;
};

class BrickCache {
 public:
  /// throws: Error kBudget where the largest brick does not fit, naming the smallest budget that works.
  BrickCache(const StoreReader& store, std::uint64_t budget_bytes);

  /// The brick, from memory or from disk; it stays while the caller holds it. thread: one caller at a time.
  /// throws: Error kBudget where held bricks leave no room, and what StoreReader::read throws.
  std::shared_ptr<const BrickBlock> get(const BrickKey& key);

  const CacheCounts& counts() const { return counts_; }
  std::uint64_t budgetBytes() const { return budget_bytes_; }
  /// The most that was charged at any time. unit: bytes.
  std::uint64_t peakBytes() const { return peak_bytes_; }

 private:
  struct Slot {
    std::shared_ptr<const BrickBlock> block;
    std::list<BrickKey>::iterator recency;
  };
  void makeRoom(std::uint64_t bytes);

  const StoreReader& store_;
  std::uint64_t budget_bytes_;
  std::uint64_t held_bytes_ = 0, peak_bytes_ = 0;
  std::map<BrickKey, Slot> slots_;
  std::list<BrickKey> recency_;  // most recent first
  CacheCounts counts_;
};

}  // namespace kiln
