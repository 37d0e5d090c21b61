#include "cache/brick_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "base/error.h"
#include "base/memory.h"

namespace kiln {
namespace {

std::uint64_t largestReadBytes(const StoreReader& store) {
  std::uint64_t largest = 0;
  const BrickIndex& index = store.index();
  for (int level = 0; level < index.levels(); ++level) {
    const Extent3& n = index.lattice(level);
    for (std::int64_t i = 0; i < n.count(); ++i) {
      largest = std::max<std::uint64_t>(largest, store.readBytes({level, brickAt(n, i)}));
    }
  }
  return largest;
}

}  // namespace

BrickCache::BrickCache(const StoreReader& store, std::uint64_t budget_bytes)
    : store_(store), budget_bytes_(budget_bytes) {
  const std::uint64_t smallest = largestReadBytes(store);
  if (smallest > budget_bytes) {
    throw Error(ErrorCode::kBudget, store.path(), "--memory",
                fmt::format("{} is too little: reading one brick takes {}; give at least that",
                            formatBytes(budget_bytes), formatBytes(smallest)));
  }
}

void BrickCache::makeRoom(std::uint64_t bytes) {
  for (auto oldest = recency_.end(); oldest != recency_.begin() && held_bytes_ + bytes > budget_bytes_;) {
    --oldest;
    const auto slot = slots_.find(*oldest);
    if (slot->second.block.use_count() > 1) continue;
    held_bytes_ -= slot->second.block->bytes();
    slots_.erase(slot);
    oldest = recency_.erase(oldest);
  }
  if (held_bytes_ + bytes > budget_bytes_) {
    throw Error(ErrorCode::kBudget, store_.path(), "--memory",
                fmt::format("{} is too little: {} are in use and the next brick takes {}", formatBytes(budget_bytes_),
                            formatBytes(held_bytes_), formatBytes(bytes)));
  }
}

std::shared_ptr<const BrickBlock> BrickCache::get(const BrickKey& key) {
  if (const auto found = slots_.find(key); found != slots_.end()) {
    recency_.splice(recency_.begin(), recency_, found->second.recency);
    ++counts_.hits;
    return found->second.block;
  }
  const std::uint64_t needed = store_.readBytes(key);
  makeRoom(needed);
  peak_bytes_ = std::max(peak_bytes_, held_bytes_ + needed);
  const auto begin = std::chrono::steady_clock::now();
  auto block = std::make_shared<const BrickBlock>(store_.read(key));
  counts_.load_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const BrickEntry& entry = store_.index().at(key);
  ++(entry.constant ? counts_.constants : counts_.reads);
  counts_.read_bytes += entry.file_bytes;
  held_bytes_ += block->bytes();
  recency_.push_front(key);
  slots_.emplace(key, Slot{block, recency_.begin()});
  return block;
}

}  // namespace kiln
